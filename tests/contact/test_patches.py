"""Patches and areas of contact: counted by hand, exact cases, convergence with the pixel."""

import itertools
from collections import deque

import numpy as np
import pytest
from some_rows import some

import roughsim as rs
from roughsim.contact.patches import Patches, patch_sizes

GRID = rs.Grid((8, 12), (4.0, 3.0))  # pixels of 0.5 by 0.25 m
UNIT = {"friction_coefficient": 1.0, "conductivity": 1.0, "diffusivity": 1.0}


def pattern(*rows):
    return np.array([[letter == "#" for letter in row] for row in rows])


def flooded(mask, *, periodic):
    """Sizes of the patches by filling them one after the other."""
    left, sizes = mask.copy(), []
    wrap = mask.shape if periodic else (1 << 30, 1 << 30)
    while left.any():
        start = tuple(np.argwhere(left)[0])
        left[start] = False
        queue, size = deque([start]), 0
        while queue:
            i, j = queue.popleft()
            size += 1
            for x, y in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
                near = (x % wrap[0], y % wrap[1])
                inside = near[0] < mask.shape[0] and near[1] < mask.shape[1]
                if inside and left[near]:
                    left[near] = False
                    queue.append(near)
        sizes.append(size)
    return sorted(sizes)


# patches


def test_patches_join_by_their_sides_and_over_the_sides_of_the_cell():
    mask = pattern(
        "#..#........",
        "............",
        "..#.........",
        "...#........",
        "............",
        ".....##.....",
        ".....#......",
        "#..........#",
    )
    found = rs.contact_patches(mask, GRID)
    np.testing.assert_array_equal(found.pixels, [3, 3, 1, 1, 1])  # corners do not join
    np.testing.assert_allclose(found.areas, np.array([3, 3, 1, 1, 1]) * 0.125, rtol=1e-15)
    assert found.count == 5
    assert found.largest == 0.375
    assert found.unresolved == 5
    assert found.unresolved_share == 1.0


@pytest.mark.parametrize(
    "shape",
    some([(1, 1), (1, 9), (9, 1), (2, 2), (2, 7), (3, 3), (17, 30), (40, 40)], 2, pairs=True),
)
@pytest.mark.parametrize("share", [0.2, 0.5, 0.7])
def test_patches_are_what_filling_them_finds(shape, share):
    rng = np.random.default_rng(3)
    for _ in range(5):
        mask = rng.random(shape) < share
        np.testing.assert_array_equal(
            rs.contact_patches(mask, rs.Grid(shape, (1.0, 1.0))).pixels[::-1],
            flooded(mask, periodic=True),
        )
        np.testing.assert_array_equal(
            np.sort(patch_sizes(mask, periodic=False)), flooded(mask, periodic=False)
        )


def test_patches_do_not_depend_on_where_the_cell_begins():
    mask = np.random.default_rng(0).random((31, 20)) < 0.45
    grid = rs.Grid(mask.shape, (1.0, 1.0))
    whole = rs.contact_patches(mask, grid).pixels
    for shift in ((7, 0), (0, 11), (30, 19)):
        np.testing.assert_array_equal(
            rs.contact_patches(np.roll(mask, shift, (0, 1)), grid).pixels, whole
        )
    np.testing.assert_array_equal(
        rs.contact_patches(mask.T, rs.Grid((20, 31), (1.0, 1.0))).pixels, whole
    )


def test_an_empty_contact_has_no_patch_and_full_contact_one():
    none = rs.contact_patches(np.zeros((8, 12), bool), GRID)
    assert none.count == none.unresolved == none.largest == 0
    assert np.isnan(none.unresolved_share)
    assert none.size_distribution().counts.size == none.size_distribution().density.size == 0
    full = rs.contact_patches(np.ones((8, 12), bool), GRID)
    assert full.count == 1
    assert full.largest == pytest.approx(12.0)
    assert full.unresolved == full.unresolved_share == 0


def test_sizes_fall_into_bins_that_double():
    strips = np.zeros((16, 64), bool)
    for row, length in zip(range(0, 16, 2), (1, 1, 2, 3, 4, 7, 8, 33), strict=True):
        strips[row, :length] = True
    found = rs.contact_patches(strips, rs.Grid((16, 64), (16.0, 64.0)))
    sizes = found.size_distribution()
    np.testing.assert_array_equal(sizes.edges, [1, 2, 4, 8, 16, 32, 64])
    np.testing.assert_array_equal(sizes.counts, [2, 2, 2, 1, 0, 1])
    np.testing.assert_array_equal(sizes.areas, [2, 5, 11, 8, 0, 33])
    np.testing.assert_allclose(sizes.density, [2, 1, 0.5, 1 / 8, 0, 1 / 32], rtol=1e-15)
    assert found.unresolved == 4
    assert found.unresolved_share == pytest.approx(7 / 59)


@pytest.mark.parametrize("pixels", [1, 2, 3, 4, 2**31, 2**52 - 1, 2**52])
def test_the_bin_of_a_size_is_exact(pixels):
    sizes = Patches(np.array([pixels]), 1.0).size_distribution()
    assert sizes.edges[-2] <= pixels < sizes.edges[-1]


# areas


def test_the_strip_along_the_edge_is_taken_off():
    # a block of 3 × 5 pixels has 6 sides across x and 10 across y; each takes 0.1 of a pixel
    mask = np.zeros((8, 12), bool)
    mask[7:, 3:8] = mask[:2, 3:8] = True  # over the side of the cell
    assert rs.corrected_area(mask, GRID) == pytest.approx((15 - 0.1 * 16) * 0.125, rel=1e-14)
    square = rs.Grid((8, 12), (2.0, 3.0))  # A − c S Δx with S = 16 sides of 0.25 m
    assert rs.corrected_area(mask, square) == pytest.approx(15 / 16 - 0.1 * 4.0 * 0.25, rel=1e-14)


def test_full_empty_and_one_dimensional_contact_have_the_edges_that_they_have():
    assert rs.corrected_area(np.ones((8, 12), bool), GRID) == pytest.approx(12.0, rel=1e-14)
    assert rs.corrected_area(np.zeros((8, 12), bool), GRID) == 0.0
    line = np.arange(12)[None] < 5
    assert rs.corrected_area(line, rs.Grid((1, 12), (1.0, 12.0))) == pytest.approx(5 - 2 * 0.1)
    stripes = np.arange(2)[:, None] < 1  # a cell of two pixels: one has the other on both sides
    assert rs.corrected_area(stripes, rs.Grid((2, 1), (2.0, 1.0))) == pytest.approx(1 - 2 * 0.1)


def test_sides_between_nothing_and_the_hardness_are_not_corrected():
    pressure = np.array([[0.0, 0.0, 2.0, 2.0, 1.0, 0.0]])  # sides: 0|σ_P, σ_P|elastic, elastic|0
    contact, plastic = rs.corrected_fractions(pressure, 2.0)
    assert contact == pytest.approx((3 - 0.1) / 6, rel=1e-14)
    assert plastic == pytest.approx((2 + 0.1) / 6, rel=1e-14)
    assert rs.corrected_fractions(pressure) == (pytest.approx((3 - 2 * 0.1) / 6, rel=1e-14), 0.0)
    single = np.array([[0.0, 0.1, 0.05]], np.float32)
    assert rs.corrected_fractions(single, 0.1)[1] > 1 / 3
    contact, plastic = rs.corrected_fractions(np.where(np.eye(6) > 0, 2.0, 0.0), 2.0)
    assert contact == plastic == pytest.approx(1 / 6, rel=1e-14)  # A = σ₀/σ_P


def test_corrected_fractions_keep_their_order():
    rng = np.random.default_rng(0)
    for share in (0.05, 0.3, 0.6, 0.95):
        pressure = rng.choice(
            [0.0, 1.0, 2.0], size=(30, 30), p=[(1 - share) / 2, share, (1 - share) / 2]
        )
        contact, plastic = rs.corrected_fractions(pressure, 2.0)
        assert 0 <= plastic <= contact <= 1


def test_areas_are_corrected_alike_in_a_cell_that_is_counted_in_several_blocks():
    kinds = np.random.default_rng(3).choice(
        [0.0, 1.0, 2.0], size=(700, 1000)
    )  # three blocks, the last one shorter
    empty, elastic, yielded = (kinds == value for value in (0.0, 1.0, 2.0))

    def sides(other):
        return sum(
            np.sum(elastic & np.roll(other, way, axis)) for axis in (0, 1) for way in (1, -1)
        )

    strip = 0.1 / kinds.size
    expected = 1 - empty.mean() - strip * sides(empty), yielded.mean() + strip * sides(yielded)
    assert rs.corrected_fractions(kinds, 2.0) == pytest.approx(expected, rel=1e-13)


def solved(heights, grid, load, hardness=np.inf, tolerance=1e-6):
    return rs.solve_contact(
        heights, grid, rs.Solid(1.0, hardness), nominal_pressure=load, tolerance=tolerance
    )


def test_the_area_of_a_hertz_contact_errs_by_a_pixel_less_after_correction():
    # exact with the curvature that the images in a periodic cell add: Σ 1/R³ over the square lattice is 4ζ(3/2)β(3/2)
    lattice, reach, radius = 9.033621683100950, 0.1, 5.0
    raw, corrected = [], []
    for points in (64, 128, 256):
        errors = []
        for x0, y0 in np.random.default_rng(0).random((8, 2)):
            x, y = ((np.arange(points) + shift) / points - 0.5 for shift in (x0, y0))
            force = 4 * reach**3 / (3 * radius)
            area = np.pi * reach**2 * (1 + 2 * radius * lattice / 4 * force / np.pi) ** (-2 / 3)
            contact = solved(
                -np.add.outer(x**2, y**2) / (2 * radius),
                rs.Grid((points, points), (1.0, 1.0)),
                force,
            )
            cut = rs.corrected_area(contact.pressure > 0, rs.Grid((points, points), (1.0, 1.0)))
            errors.append([contact.contact_fraction / area - 1, cut / area - 1])
        means = np.mean(errors, axis=0)
        raw.append(means[0])
        corrected.append(means[1])
    rate = -np.polyfit(np.log([64, 128, 256]), np.log(raw), 1)[0]
    assert rate == pytest.approx(1.0, abs=0.2)
    assert (np.abs(corrected) < 0.5 * np.array(raw)).all()


@pytest.mark.slow
def test_a_wave_turned_on_the_grid_has_its_exact_area_on_average_over_all_directions():
    # Westergaard's wave touches on A = (2/π) arcsin √(σ₀/p*), p* = πE*h/λ, whatever its direction. Of all lattice
    # vectors of 8 to 13 waves in an eighth of the plane, each counts for its share of the angles and for the sides of
    # an edge in its direction, cos + sin; by itself each errs by up to .09 pixel along its edge
    rng, points, height = np.random.default_rng(4), 256, 1e-3
    grid = rs.Grid((points, points), (1.0, 1.0))
    vectors = [
        (a, b)
        for a in range(14)
        for b in range(a + 1)
        if 8 <= np.hypot(a, b) <= 13 and np.gcd(a, b) == 1
    ]
    vectors.append((11, 0))
    vectors.sort(key=lambda each: each[1] / each[0])
    x = np.arange(points) / points
    raw, left = [], []  # error of the area over the sides of its edge, in pixels
    for a, b in vectors:
        over, sides = np.zeros(2), 0.0
        for load, phase in zip(
            rng.uniform(0.1, 0.6, 3), rng.uniform(0.0, 2.0 * np.pi, 3), strict=True
        ):
            heights = height * np.cos(2 * np.pi * np.add.outer(a * x, b * x) + phase)
            contact = solved(heights, grid, load * np.pi * height * np.hypot(a, b))
            mask = contact.pressure > 0
            areas = np.array([mask.mean(), rs.corrected_area(mask, grid)])
            over += areas - 2 / np.pi * np.arcsin(np.sqrt(load))
            sides += sum(np.mean(mask != np.roll(mask, 1, axis)) for axis in (0, 1))
        raw.append(over[0] / sides)
        left.append(over[1] / sides)
    angle = np.arctan2(*np.transpose(vectors)[::-1])
    bounds = np.concatenate([[0.0], (angle[1:] + angle[:-1]) / 2, [np.pi / 4]])
    weight = np.diff(bounds) * (np.cos(angle) + np.sin(angle))
    assert np.average(raw, weights=weight) > 0.09
    assert np.average(left, weights=weight) == pytest.approx(0.0, abs=0.0025)


def test_the_bisinusoidal_wave_leaves_its_last_holes_as_known():
    # A = 1 − (3/2π)(1 − p/p*), p* = √2πE*Δ/λ (Johnson, Greenwood & Higginson 1985), up to the square of 1 − p/p*
    grid = rs.Grid((384, 384), (1.0, 1.0))
    for share, known in ((0.97, 0.985676), (0.99, 0.995225)):
        areas = []
        for shift in (0.0, 0.21, 0.37, 0.5):
            wave = np.cos(2 * np.pi * (np.arange(384) + shift) / 384)
            contact = solved(
                0.01 * np.outer(wave, wave), grid, share * np.sqrt(2) * np.pi * 0.01, tolerance=1e-7
            )
            areas.append(rs.corrected_area(contact.pressure > 0, grid))
        assert np.mean(areas) == pytest.approx(known, abs=0.25 * (1 - share) ** 2 + 5e-5)


def rough(points, seed, *, waves=16, roll_off=2):
    grid, q_min = rs.Grid((points, points), (1.0, 1.0)), 2 * np.pi
    ends = {"q_min": q_min, "q_roll_off": roll_off * q_min, "q_max": waves * q_min}
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(1.0, hurst=0.8, **ends)
    return rs.synthesize(spectrum, grid, np.random.default_rng(seed)), grid


def fractions(points, load, hardness):
    """Means over three surfaces: contact and plastic, by pixels and corrected."""
    found = []
    for seed in range(3):
        heights, grid = rough(points, seed)
        contact = solved(heights, grid, load, hardness)
        corrected = rs.corrected_fractions(contact.pressure, hardness)
        found.append([contact.contact_fraction, contact.plastic_fraction, *corrected])
    return np.reshape(np.mean(found, axis=0), (2, 2))


@pytest.mark.parametrize("load", [0.02, pytest.param(0.1, marks=pytest.mark.slow), 0.4])
def test_corrected_areas_of_rough_contact_are_the_limit_of_counted_ones(load):
    counted = {}
    corrected = {}
    for points in (64, 128, 256, 512):  # 4 to 32 pixels per shortest wave
        counted[points], corrected[points] = fractions(points, load, np.inf)[:, 0]
    limit = (
        2 * counted[512] - counted[256]
    )  # the strip along the edge is in proportion to the pixel
    for points in (64, 128, 256):
        assert counted[points] / limit - 1 > 1.6 / points
        assert abs(corrected[points] - limit) < 0.25 * (counted[points] - limit)
    # 0.118 pixels in place of 0.1 would err by 2 to 6 parts in 1000
    assert corrected[256] == pytest.approx(limit, rel=1.5e-3)


def test_pixels_add_contact_area_and_take_yielded_area():
    fine = fractions(512, 0.02, 0.5)[1]
    for points in (64, 128, 256):
        raw, corrected = fractions(points, 0.02, 0.5) - fine
        assert raw[0] > 0 > raw[1]
        assert (np.abs(corrected) < 0.5 * np.abs(raw)).all()


def test_a_yielding_wave_is_too_narrow_by_as_much_as_a_touching_one_is_too_wide():
    # Westergaard's wave, A = (2/π) arcsin √(σ₀/p*), and the same upside down. Its edges lie along the rows, at many
    # places within a pixel: .19 of a pixel at each
    flattening = np.pi * 0.01
    wide, narrow = [], []
    for points, phase in itertools.product((41, 81), (np.arange(6) + 0.3) / 6):
        grid, angle = (
            rs.Grid((points, 1), (1.0, 1.0)),
            2 * np.pi * (np.arange(points) + phase) / points,
        )
        heights = 0.01 * np.cos(angle)[:, None]
        for exact in np.linspace(0.25, 0.5, 10, endpoint=False):
            share = np.sin(np.pi / 2 * exact) ** 2
            touching = solved(heights, grid, share * flattening)
            yielding = solved(-heights, grid, (10 - share) * flattening, 10 * flattening)
            np.testing.assert_array_equal(
                touching.pressure == 0, yielding.pressure == 10 * flattening
            )
            wide.append((touching.contact_fraction - exact) * points / 2)
            narrow.append((1 - exact - yielding.plastic_fraction) * points / 2)
    assert np.mean(wide) == pytest.approx(0.19, abs=0.006)
    np.testing.assert_allclose(narrow, wide, rtol=0, atol=1e-9)


@pytest.mark.slow
@pytest.mark.statistical
def test_the_area_grows_with_the_load_at_the_known_slope():
    # A E*h′/σ₀ between √(8/π) (Persson) and √(2π) (Bush, Gibson & Thomas), by four standard errors of 16 surfaces; at 8
    # pixels per shortest wave the pixels by themselves lie above
    low, high, means = np.sqrt(8 / np.pi), np.sqrt(2 * np.pi), []
    for load in (0.01, 0.02, 0.05):
        slopes = []
        for seed in range(16):
            heights, grid = rough(256, seed, waves=32, roll_off=8)
            contact = solved(heights, grid, load, tolerance=1e-4)
            slopes.append(
                [
                    contact.contact_fraction / load,
                    rs.corrected_area(contact.pressure > 0, grid) / load,
                ]
            )
        raw, mean = np.mean(slopes, axis=0)
        error = 4 * np.std(slopes, axis=0, ddof=1) / 4
        assert low + error[1] < mean < high - error[1]
        assert load > 0.01 or raw - error[0] > high
        means.append(mean)
    assert means == sorted(means, reverse=True)  # later contacts grow together


def test_measured_fractions_are_those_of_the_pressure():
    heights, grid = rough(64, 0)
    for hardness in (np.inf, 0.3):
        contact = solved(heights, grid, 0.05, hardness)
        seen = rs.measure(contact, grid, rs.HeatSource([1.0], **UNIT))
        expected = rs.corrected_fractions(contact.pressure, hardness)
        assert (seen.contact_fraction_corrected, seen.plastic_fraction_corrected) == expected
    assert expected[1] > contact.plastic_fraction > 0
