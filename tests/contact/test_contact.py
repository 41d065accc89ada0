"""Contact: exact solutions, optimality judged from outside, symmetries."""

import itertools

import numpy as np
import pytest
from contact_cases import (
    UNIT,
    WAVE,
    WAVE_PRESSURE,
    assert_solved,
    displacement_by_dft,
    q_plane,
    rough,
)
from some_rows import some

import roughsim as rs


def westergaard(load, points):
    """Pressure of the wave along x: closed form (Westergaard 1939)."""
    x = np.arange(points) / points
    x = np.minimum(x, 1 - x)
    if load >= WAVE_PRESSURE:
        return load + WAVE_PRESSURE * np.cos(2 * np.pi * x)
    edge2 = load / WAVE_PRESSURE  # sin²(π a/λ)
    inside = np.maximum(edge2 - np.sin(np.pi * x) ** 2, 0.0)
    return 2 * load / edge2 * np.cos(np.pi * x) * np.sqrt(inside)


@pytest.mark.parametrize("fraction", [1e-6, 1e-3, 0.3, 0.9, 0.999, 1.0, 2.0])
def test_westergaards_wave_has_its_contact_area_at_any_load(fraction):
    contact = rs.solve_contact(WAVE, UNIT, rs.Solid(1.0), nominal_pressure=fraction * WAVE_PRESSURE)
    area = 2 / np.pi * np.arcsin(np.sqrt(min(fraction, 1.0)))
    assert contact.contact_fraction == pytest.approx(
        area, abs=2 / 64
    )  # a row of pixels at each edge: the resolution
    assert_solved(WAVE, UNIT, rs.Solid(1.0), fraction * WAVE_PRESSURE, contact)


def test_westergaards_pressure_is_approached_as_the_grid_is_refined():
    errors = []
    for points in (64, 128, 256, 512):
        grid = rs.Grid((points, 1), (1.0, 1.0))
        heights = 0.01 * np.cos(2 * np.pi * np.arange(points) / points)[:, None]
        exact = westergaard(0.4 * WAVE_PRESSURE, points)
        contact = rs.solve_contact(
            heights, grid, rs.Solid(1.0), nominal_pressure=0.4 * WAVE_PRESSURE, tolerance=1e-9
        )
        errors.append(np.linalg.norm(contact.pressure[:, 0] - exact) / np.linalg.norm(exact))
    rate = -np.polyfit(np.log([64, 128, 256, 512]), np.log(errors), 1)[0]
    assert errors[-1] < 0.004
    assert rate > 0.8  # a square-root edge: first order at least


def test_westergaards_wave_in_full_contact_is_exact():
    for fraction in (1.0, 1.0 + 1e-9, 2.0):
        load = fraction * WAVE_PRESSURE
        contact = rs.solve_contact(WAVE, UNIT, rs.Solid(1.0), nominal_pressure=load)
        np.testing.assert_allclose(contact.pressure[:, 0], westergaard(load, 64), atol=1e-15)


def test_a_paraboloid_presses_as_hertz_says():
    # periodic images act at distance L: a/L = 0.08 keeps them below the pixel error
    points, radius, modulus = 512, 5.0, 2.0
    grid = rs.Grid((points, points), (1.0, 1.0))
    x = (np.arange(points) - points // 2) / points
    heights = -np.add.outer(x**2, x**2) / (2 * radius)
    a = 0.08
    force = 4 * modulus * a**3 / (3 * radius)
    contact = rs.solve_contact(heights, grid, rs.Solid(modulus), nominal_pressure=force)
    assert contact.contact_fraction == pytest.approx(np.pi * a**2, rel=0.01)
    assert contact.pressure.max() == pytest.approx(2 * modulus * a / (np.pi * radius), rel=0.01)
    r = np.hypot.outer(x, x)
    hertz = 2 * modulus / (np.pi * radius) * np.sqrt(np.maximum(a**2 - r**2, 0))
    assert np.linalg.norm(contact.pressure - hertz) < 0.015 * np.linalg.norm(hertz)


@pytest.mark.parametrize("over", [1.0001, 1.5])
def test_full_contact_is_the_closed_form(over):
    heights, grid = rough()
    full = np.fft.ifft2(np.fft.fft2(heights) * 3.0 * q_plane(grid) / 2).real
    load = over * np.abs(full).max()
    contact = rs.solve_contact(heights, grid, rs.Solid(3.0), nominal_pressure=load)
    np.testing.assert_allclose(contact.pressure, load + full, rtol=1e-9, atol=1e-12 * load)
    assert contact.contact_fraction == 1.0


def test_the_displacement_is_that_of_the_pressure():
    heights, grid = rough()
    for load in (0.01, 5.0):
        contact = rs.solve_contact(heights, grid, rs.Solid(1.3), nominal_pressure=load)
        expected = displacement_by_dft(contact.pressure, grid, 1.3)
        np.testing.assert_allclose(contact.displacement, expected, atol=1e-14)


def test_a_flat_a_pixel_and_a_yielded_surface_carry_their_load_uniformly():
    heights, grid = rough()
    for surface, cell, solid, load in (
        (np.full((64, 64), 7.0), UNIT, rs.Solid(1.0), 1e-3),
        (np.ones((1, 1)), rs.Grid((1, 1), (1.0, 1.0)), rs.Solid(1.0, 2.0), 1.0),
        (heights, grid, rs.Solid(1.0, 0.01), 0.01),
    ):
        contact = rs.solve_contact(surface, cell, solid, nominal_pressure=load)
        np.testing.assert_allclose(contact.pressure, load, rtol=1e-14)
        assert contact.contact_fraction == 1.0
    assert contact.plastic_fraction == 1.0


def test_the_rigid_limit_yields_the_highest_points():
    # Y ≪ E*: the contact is the bearing area, A = σ₀/σ_P
    heights, grid = rough()
    contact = rs.solve_contact(heights * 100, grid, rs.Solid(1.0, 1e-4), nominal_pressure=1e-5)
    count = round(0.1 * heights.size)
    highest = np.sort(heights, axis=None)[-count:]
    assert contact.plastic_fraction == pytest.approx(0.1, abs=1 / heights.size)
    assert heights[contact.pressure > 0].min() >= highest[0] - 1e-15


def test_tied_ridges_share_the_load():
    heights = np.where(np.add.outer(np.arange(64), np.arange(64)) % 64 == 0, 0.01, 0.0)
    contact = rs.solve_contact(heights, UNIT, rs.Solid(1.0), nominal_pressure=1e-7)
    assert contact.contact_fraction == 1 / 64
    assert contact.pressure.max() == pytest.approx(6.4e-6, rel=1e-9)


def surfaces():
    """Hard surfaces by name: what stresses a contact solver."""
    rng = np.random.default_rng(1)
    plateau, step = np.zeros((64, 64)), np.zeros((64, 64))
    plateau[20:40, 25:45] = step[:32] = 0.01
    return {
        "plateau": (plateau, UNIT),
        "step": (step, UNIT),
        "white noise": (0.01 * rng.standard_normal((64, 64)), UNIT),
        "heavy tail": (0.01 * np.exp(2 * rng.standard_normal((64, 64))), UNIT),
        "no short cut-off, H = 0": rough(hurst=0.0, per_wave=2),
        "no short cut-off, H = 1": rough(hurst=1.0, per_wave=2),
        "slope 10": rough(slope=10.0, per_wave=2),
        "slope 1e-8": rough(slope=1e-8),
        "odd": rough(63),
        "prime": rough((61, 67)),
        "mixed": rough((127, 64), lengths=(1.0, 1.0)),
        "oblong cell": rough((64, 64), lengths=(1.0, 3.0)),
        "large offset": (rough()[0] - 1e3, UNIT),
        "3 × 3": (0.01 * rng.standard_normal((3, 3)), rs.Grid((3, 3), (1.0, 1.0))),
        "2 × 7": (0.01 * rng.standard_normal((2, 7)), rs.Grid((2, 7), (1.0, 1.0))),
    }


SURFACES = surfaces()


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("cap", some([np.inf, 1.0001, 2.0, 50.0], 2))
@pytest.mark.parametrize("load", some([1e-3, 0.1, 0.9], 2))
def test_hard_surfaces_meet_the_optimality_conditions(name, cap, load):
    heights, grid = SURFACES[name]
    full = np.fft.ifft2(np.fft.fft2(heights) * q_plane(grid) / 2).real
    pressure = load * np.abs(full).max()
    solid = rs.Solid(1.0, cap * pressure)
    contact = rs.solve_contact(heights, grid, solid, nominal_pressure=pressure)
    assert_solved(heights, grid, solid, pressure, contact)


@pytest.mark.parametrize("load", [1e-300, 1e-16, 1e-8, 1e6])
def test_loads_from_less_than_a_pixel_to_beyond_full_contact(load):
    heights, grid = rough()
    contact = rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=load)
    assert contact.pressure.mean() == pytest.approx(load, rel=1e-12)
    assert contact.contact_fraction == (1.0 if load > 1 else 1 / 4096)


@pytest.mark.parametrize("length", [1e-100, 1e-9, 1e9, 1e100])
@pytest.mark.parametrize("modulus", [1e-100, 1.0, 1e160])
def test_units_do_not_matter(length, modulus):
    heights, grid = rough()
    base = rs.solve_contact(heights, grid, rs.Solid(1.0, 0.05), nominal_pressure=0.01)
    scaled_grid = rs.Grid(grid.shape, (length, length))
    solid = rs.Solid(modulus, 0.05 * modulus)
    scaled = rs.solve_contact(heights * length, scaled_grid, solid, nominal_pressure=0.01 * modulus)
    np.testing.assert_allclose(scaled.pressure / modulus, base.pressure, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(scaled.pressure > 0, base.pressure > 0)


def test_shift_mirror_rotation_and_tiling_carry_over_to_the_pressure():
    heights, grid = rough()
    solve = dict(solid=rs.Solid(1.0, 0.05), nominal_pressure=0.01, tolerance=1e-10)
    base = rs.solve_contact(heights, grid, **solve).pressure
    double = rs.Grid((128, 128), (2.0, 2.0))
    for change, cell in (
        (lambda f: np.roll(f, (5, -11), (0, 1)), grid),
        (lambda f: f[::-1], grid),
        (np.rot90, grid),
        (lambda f: np.tile(f, (2, 2)), double),
    ):
        moved = rs.solve_contact(np.ascontiguousarray(change(heights)), cell, **solve).pressure
        np.testing.assert_allclose(moved, change(base), atol=1e-8 * base.max())


def test_the_plastically_deformed_surface_repeats_the_stress_elastically():
    # an identity of the optimality conditions: the overlap removed where p = σ_P leaves zero gap there
    heights, grid = rough(128, slope=0.5)
    solid = rs.Solid(1.0, 0.1)
    contact = rs.solve_contact(heights, grid, solid, nominal_pressure=0.03, tolerance=1e-9)
    gap = contact.displacement - heights
    free = (contact.pressure > 0) & (contact.pressure < 0.1)
    overlap = np.where(contact.pressure >= 0.1, gap[free].mean() - gap, 0.0)
    again = rs.solve_contact(
        heights - overlap, grid, rs.Solid(1.0), nominal_pressure=0.03, tolerance=1e-9
    )
    difference = np.linalg.norm(again.pressure - contact.pressure)
    assert difference < 1e-8 * np.linalg.norm(contact.pressure)
    assert contact.plastic_fraction > 0.1


def test_the_contact_area_grows_with_load_at_the_known_slope():
    # A E*h′/σ₀ lies between √(8/π) (Persson) and √(2π) (Bush, Gibson & Thomas) at small load
    heights, grid = rough(256, per_wave=8, slope=1.0)
    contact = rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=0.02)
    perimeter = sum(np.count_nonzero(np.diff(contact.pressure > 0, axis=k)) for k in (0, 1)) / 256
    corrected = contact.contact_fraction - 0.1 * perimeter / 256
    assert np.sqrt(8 / np.pi) < corrected / 0.02 < np.sqrt(2 * np.pi)


def test_the_residual_is_close_to_the_pressure_error():
    heights, grid = rough(128, per_wave=8)
    for cap in (np.inf, 0.1):
        exact = rs.solve_contact(
            heights, grid, rs.Solid(1.0, cap), nominal_pressure=0.02, tolerance=1e-11
        ).pressure
        for tolerance in (1e-2, 1e-4, 1e-6):
            contact = rs.solve_contact(
                heights, grid, rs.Solid(1.0, cap), nominal_pressure=0.02, tolerance=tolerance
            )
            error = np.linalg.norm(contact.pressure - exact) / np.linalg.norm(exact)
            assert contact.residual <= tolerance
            assert error < 10 * tolerance


def test_the_same_solve_gives_the_same_bits_and_leaves_its_input_alone():
    heights, grid = rough()
    kept = heights.copy()
    heights.flags.writeable = False
    runs = [
        rs.solve_contact(heights, grid, rs.Solid(1.0, 0.1), nominal_pressure=0.02) for _ in range(2)
    ]
    np.testing.assert_array_equal(runs[0].pressure, runs[1].pressure)
    np.testing.assert_array_equal(heights, kept)


def test_any_real_array_is_understood():
    heights, grid = rough()
    whole = np.rint(heights * 1e6).astype(np.int64)
    base = rs.solve_contact(whole.astype(float), grid, rs.Solid(1.0), nominal_pressure=1e3).pressure
    padded = np.zeros((64, 128))
    padded[:, ::2] = whole
    for same in (
        whole,
        whole.tolist(),
        np.asfortranarray(whole),
        whole.astype(">f8"),
        padded[:, ::2],
    ):
        np.testing.assert_array_equal(
            rs.solve_contact(same, grid, rs.Solid(1.0), nominal_pressure=1e3).pressure, base
        )


def test_single_precision_fields_are_the_rounded_double_ones():
    heights, grid = rough()
    fields = [
        rs.solve_contact(
            heights, grid, rs.Solid(1.0, 0.1), nominal_pressure=0.02, precision=word
        ).pressure
        for word in ("double", "single")
    ]
    assert fields[1].dtype == np.float32
    np.testing.assert_allclose(fields[1], fields[0], rtol=1e-6)


def test_a_tolerance_below_rounding_stops_at_the_floor_and_says_so():
    heights, grid = rough()
    with pytest.warns(RuntimeWarning, match="tolerance = 1e-30 lies below the rounding floor"):
        contact = rs.solve_contact(
            heights, grid, rs.Solid(1.0), nominal_pressure=0.01, tolerance=1e-30
        )
    assert_solved(heights, grid, rs.Solid(1.0), 0.01, contact)


def test_too_few_iterations_raise_and_carry_the_best_field():
    heights, grid = rough()
    with pytest.raises(
        rs.ConvergenceError, match=r"stopped at the limit: residual .* after 1 iterations"
    ) as caught:
        rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=0.01, max_iterations=1)
    assert caught.value.iterations == 1
    assert caught.value.residual > 1e-6
    assert caught.value.pressure.mean() == pytest.approx(0.01)


def test_random_problems_meet_the_optimality_conditions():
    rng = np.random.default_rng(7)
    for seed, points in enumerate(itertools.islice(itertools.cycle([64, 96, 100, 128]), 24)):
        slope, share = 10 ** rng.uniform(-3, 0.5), 10 ** rng.uniform(-4, 0.3)
        heights, grid = rough(
            points, hurst=rng.random(), slope=slope, per_wave=rng.choice([2, 3, 4, 8]), seed=seed
        )
        cap = np.inf if rng.random() < 0.4 else slope * share / rng.uniform(0.02, 0.95)
        contact = rs.solve_contact(
            heights, grid, rs.Solid(1.0, cap), nominal_pressure=slope * share
        )
        assert_solved(heights, grid, rs.Solid(1.0, cap), slope * share, contact)


def test_a_load_after_others_on_the_same_heights_has_the_bits_of_one_alone():
    (heights, grid), (small, coarse) = rough(128), rough(64)
    others = rough(128, seed=1)[0]
    cases = [
        (0.1, 1e-3),
        (0.1, 0.05),
        (np.inf, 1e-2),
        (np.inf, 10.0),
        (0.1, 1e-2),
    ]  # σ_P and σ₀ over E*

    def fields(surface, hardness, load, grid=grid):
        contact = rs.solve_contact(surface, grid, rs.Solid(1.0, hardness), nominal_pressure=load)
        return np.stack((contact.pressure, contact.displacement))

    def alone(surface, case):
        fields(small, 0.1, 1e-3, coarse)  # what is kept is of this grid
        return fields(surface.copy(), *case)

    expected = [alone(heights, case) for case in cases]
    for case, values in zip(cases, expected, strict=True):
        np.testing.assert_array_equal(fields(heights, *case), values)
    fields(others, *cases[0])
    np.testing.assert_array_equal(fields(heights, *cases[0]), expected[0])
    heights[3:9] *= 0.5  # the array is another surface now
    np.testing.assert_array_equal(fields(heights, *cases[0]), alone(heights, cases[0]))
