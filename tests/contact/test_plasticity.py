"""What capped contact leaves behind: exact displacements, reloading, unloading, energy."""

import numpy as np
import pytest
from some_rows import some

import roughsim as rs

DEPTH = 0.01  # amplitude of the wave, m
FLATTENING = np.pi * DEPTH  # p* = πE*Δ/λ of that wave, E* = λ = 1


def rough(points=128, *, slope=0.5, seed=0, per_wave=4, lengths=(1.0, 1.0)):
    grid = rs.Grid((points, points), lengths)
    q_min = 2 * np.pi / min(lengths)
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        slope, hurst=0.8, q_min=q_min, q_roll_off=2 * q_min, q_max=2 * grid.nyquist / per_wave
    )
    return rs.synthesize(spectrum, grid, np.random.default_rng(seed)), grid


def press(heights, grid, solid, load, tolerance=1e-9):
    contact = rs.solve_contact(heights, grid, solid, nominal_pressure=load, tolerance=tolerance)
    return contact, rs.plastic_deformation(contact, heights, grid, solid)


def lifted(x, share):
    """Gap of Westergaard's wave at the share σ₀/p* of its full-contact load, x from the crest in wavelengths.

    The slope of the gap is the pressure formula continued: (4p*/E*) cos ψ √(sin²ψ − s²), ψ = πx, s² = σ₀/p*.
    """
    s, t = np.sqrt(share), np.abs(np.sin(np.pi * x))
    t = np.maximum(t, s)
    return 2 * DEPTH * (t * np.sqrt(t**2 - s**2) - s**2 * np.arccosh(t / s))


def yielded_wave(points, share, phase=0.31):
    """A wave that yields over its crests and touches everywhere: Westergaard's wave upside down, σ_P − p for p."""
    x = (np.arange(points) + phase) / points
    grid, heights = rs.Grid((points, 1), (1.0, 1.0)), DEPTH * np.cos(2 * np.pi * x)[:, None]
    solid = rs.Solid(1.0, 10 * FLATTENING)
    _, deformed = press(heights, grid, solid, (10 - share) * FLATTENING)
    return deformed, lifted(x - 0.5, share)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_a_wave_yields_over_its_crests_as_it_lifts_off_its_troughs(share):
    errors = []
    for points in (64, 256, 1024):
        deformed, exact = yielded_wave(points, share)
        errors.append(np.abs(deformed.displacement[:, 0] - exact).max() / DEPTH)
        assert deformed.volume == pytest.approx(exact.mean(), abs=2 * DEPTH * errors[-1])
    rate = -np.polyfit(np.log([64, 256, 1024]), np.log(errors), 1)[0]
    assert errors[-1] < 2e-4
    assert rate > 0.8  # the edge of the contact is known to a pixel


def test_a_surface_that_yields_everywhere_is_pressed_flat():
    heights, grid = rough(32)
    _, deformed = press(heights, grid, rs.Solid(1.0, 0.01), 0.01)
    np.testing.assert_allclose(deformed.displacement, heights - heights.min(), rtol=0, atol=1e-16)
    np.testing.assert_allclose(deformed.heights, heights.min(), rtol=0, atol=1e-16)
    assert deformed.flat_height == pytest.approx(heights.min(), rel=1e-12)


def test_the_rigid_limit_cuts_the_peaks_off():
    # σ_P ≪ E*: the contact is what stands above a plane, and all of that is pressed down
    heights, grid = rough(64)
    heights *= 1e4
    _, deformed = press(heights, grid, rs.Solid(1.0, 1e-4), 1e-5)
    plane = np.quantile(heights, 0.9)
    np.testing.assert_allclose(
        deformed.heights, np.minimum(heights, plane), rtol=0, atol=2e-3 * np.ptp(heights)
    )
    assert deformed.flat_height == pytest.approx(plane, abs=2e-3 * np.ptp(heights))


@pytest.mark.parametrize("hardness", [np.inf, 1e3])
def test_elastic_contact_leaves_nothing_behind(hardness):
    heights, grid = rough(64)
    kept = heights.copy()
    heights.flags.writeable = False
    contact, deformed = press(heights, grid, rs.Solid(1.0, hardness), 0.02)
    assert not deformed.displacement.any()
    assert deformed.volume == 0.0
    np.testing.assert_array_equal(deformed.heights, kept)
    touching = contact.pressure > 0  # there the elastic surface lies on the flat
    level = (heights - contact.displacement)[touching]
    np.testing.assert_allclose(level, deformed.flat_height, rtol=0, atol=1e-8 * np.ptp(heights))


@pytest.mark.parametrize("tolerance", some([1e-2, 1e-4, 1e-6, 1e-9], 2))
@pytest.mark.parametrize(("load", "hardness"), [(0.03, 0.1), (0.01, 0.5), (0.05, 0.06), (0.6, 0.7)])
def test_the_deformed_surface_repeats_the_pressures_elastically_and_without_new_yielding(
    tolerance, load, hardness
):
    heights, grid = rough()
    solid = rs.Solid(1.0, hardness)
    contact, deformed = press(heights, grid, solid, load, tolerance)
    assert contact.plastic_fraction > 0.0
    for again in (rs.Solid(1.0), solid):
        reloaded, more = press(deformed.heights, grid, again, load, tolerance)
        difference = np.linalg.norm(reloaded.pressure - contact.pressure)
        assert difference < 10 * tolerance * np.linalg.norm(contact.pressure)
        assert more.volume < 10 * tolerance * deformed.volume


def hard_surfaces():
    rng = np.random.default_rng(1)
    plateau, step = np.zeros((64, 64)), np.zeros((64, 64))
    plateau[20:40, 25:45] = step[:32] = 0.01
    unit = rs.Grid((64, 64), (1.0, 1.0))
    return {
        "plateau": (plateau, unit),
        "step": (step, unit),
        "white noise": (0.01 * rng.standard_normal((64, 64)), unit),
        "heavy tail": (0.01 * np.exp(2 * rng.standard_normal((64, 64))), unit),
        "steep": rough(64, slope=10.0, per_wave=2),
        "smooth": rough(64, slope=1e-8),
        "prime": rough(61),
        "oblong": (rough(64)[0], rs.Grid((64, 64), (1.0, 3.0))),
        "3 × 3": (0.01 * rng.standard_normal((3, 3)), rs.Grid((3, 3), (1.0, 1.0))),
        "1 × 128": (
            0.01 * np.cumsum(rng.standard_normal((1, 128))).reshape(1, 128),
            rs.Grid((1, 128), (1.0, 1.0)),
        ),
    }


HARD = hard_surfaces()


@pytest.mark.slow
@pytest.mark.parametrize("name", HARD)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6, 1e-9])
def test_pressures_repeat_on_hard_surfaces(name, tolerance):
    heights, grid = HARD[name]
    q = np.hypot(
        *np.meshgrid(*(np.fft.fftfreq(n, d) for n, d in zip(grid.shape, grid.spacing, strict=True)))
    ).T
    flattening = np.abs(np.fft.ifft2(np.fft.fft2(heights) * np.pi * q)).max()
    for share in (1e-3, 0.1, 0.9):
        for ratio in (1.0001, 2.0, 50.0):
            solid = rs.Solid(1.0, ratio * share * flattening)
            contact, deformed = press(heights, grid, solid, share * flattening, tolerance)
            for again in (rs.Solid(1.0), solid):
                reloaded, _ = press(deformed.heights, grid, again, share * flattening, tolerance)
                difference = np.linalg.norm(reloaded.pressure - contact.pressure)
                assert difference < 3 * tolerance * np.linalg.norm(contact.pressure)


def test_a_load_that_returns_again_and_again_deforms_once():
    heights, grid = rough(64)
    first, *later = rs.follow_loads(
        heights,
        grid,
        rs.Solid(1.0, 0.1),
        nominal_pressures=[0.03, 0.003] * 10 + [0.03],
        tolerance=1e-8,
    )
    added = sum(step.deformation.volume for step in later)
    assert added < 1e-7 * first.deformation.volume


@pytest.mark.parametrize("share", [0.01, 0.3, 0.9])
def test_unloading_is_elastic_and_keeps_more_contact_than_loading(share):
    heights, grid = rough()
    solid, peak = rs.Solid(1.0, 0.2), 0.05
    top, deformed = press(heights, grid, solid, peak)
    down, more = press(deformed.heights, grid, solid, share * peak)
    up, _ = press(heights, grid, solid, share * peak)
    free, _ = press(deformed.heights, grid, rs.Solid(1.0), share * peak)
    assert down.plastic_fraction == more.volume == 0.0
    np.testing.assert_allclose(
        down.pressure, free.pressure, rtol=0, atol=1e-7 * solid.penetration_hardness
    )
    assert down.contact_fraction > up.contact_fraction
    assert (
        down.pressure <= top.pressure + 1e-7
    ).all()  # a body that is relieved is relieved everywhere


def test_loads_in_steps_deform_as_the_highest_at_once():
    # yielded areas only grow and the overlap with them, so nothing is remembered but the highest load
    heights, grid = rough()
    solid, path = rs.Solid(1.0, 0.2), [0.01, 0.002, 0.03, 0.015, 0.06]
    steps = list(rs.follow_loads(heights, grid, solid, nominal_pressures=path, tolerance=1e-9))
    contact, deformed = press(heights, grid, solid, path[-1])
    total = sum(step.deformation.displacement for step in steps)
    np.testing.assert_allclose(total, deformed.displacement, rtol=0, atol=1e-7 * np.ptp(heights))
    np.testing.assert_allclose(
        steps[-1].deformation.heights, deformed.heights, rtol=0, atol=1e-7 * np.ptp(heights)
    )
    np.testing.assert_allclose(steps[-1].contact.pressure, contact.pressure, rtol=0, atol=1e-7)
    assert [step.deformation.volume > 0 for step in steps] == [True, False, True, False, True]


def test_the_work_of_loading_is_elastic_energy_and_hardness_times_volume():
    # ∫σ₀ dz over the way of the flat, by the trapezoidal rule on loads that double: its error falls fourfold
    heights, grid = rough(64, slope=1.0)
    solid, errors = rs.Solid(1.0, 0.3), []
    for count in (8, 16, 32):
        loads = (
            0.1 * (np.arange(1, count + 1) / count) ** 2
        )  # the flat first moves far at small loads
        pressed = [press(heights, grid, solid, load, 1e-8) for load in loads]
        z = np.array([heights.max()] + [deformed.flat_height for _, deformed in pressed])
        force = np.concatenate([[0.0], loads])
        work = -np.sum(np.diff(z) * (force[1:] + force[:-1]) / 2)
        contact, deformed = pressed[-1]
        elastic = 0.5 * np.mean(contact.pressure * contact.displacement)
        plastic = solid.penetration_hardness * deformed.volume
        assert plastic > elastic
        errors.append(abs(work / (elastic + plastic) - 1))
    assert errors[-1] < 2e-3
    assert errors[0] / errors[1] > 3
    assert errors[1] / errors[2] > 3


def test_lengths_and_pressures_carry_their_units():
    heights, grid = rough(64)
    _, base = press(heights, grid, rs.Solid(1.0, 0.1), 0.03)
    length, modulus = 1e-6, 1e11
    small = rs.Grid(grid.shape, (length, length))
    _, scaled = press(heights * length, small, rs.Solid(modulus, 0.1 * modulus), 0.03 * modulus)
    np.testing.assert_allclose(
        scaled.displacement / length, base.displacement, rtol=0, atol=1e-8 * np.ptp(heights)
    )
    assert scaled.volume / length**3 == pytest.approx(base.volume, rel=1e-7)
    assert scaled.flat_height / length == pytest.approx(base.flat_height, rel=1e-7)


def test_the_volume_is_that_of_the_cell():
    # a cell of twice the size holds the surface four times, and four times the volume
    heights, grid = rough(64, lengths=(1.0, 1.0))
    double = rs.Grid((128, 128), (2.0, 2.0))
    _, one = press(heights, grid, rs.Solid(1.0, 0.1), 0.03)
    _, four = press(np.tile(heights, (2, 2)), double, rs.Solid(1.0, 0.1), 0.03)
    assert four.volume == pytest.approx(4 * one.volume, rel=1e-6)
    assert four.flat_height == pytest.approx(one.flat_height, rel=1e-6)


def test_single_precision_fields_know_what_has_yielded():
    heights, grid = rough(64)
    solid = rs.Solid(1.0, 0.1)  # 0.1 is no number of either precision
    double, single = (
        rs.solve_contact(heights, grid, solid, nominal_pressure=0.03, precision=word)
        for word in ("double", "single")
    )
    wide, narrow = (
        rs.plastic_deformation(contact, heights, grid, solid) for contact in (double, single)
    )
    assert narrow.displacement.dtype == np.float64
    np.testing.assert_allclose(
        narrow.displacement, wide.displacement, rtol=0, atol=1e-6 * np.ptp(heights)
    )
    assert narrow.volume == pytest.approx(wide.volume, rel=1e-4)


def test_no_loads_are_no_steps_and_the_hardness_itself_is_one():
    heights, grid = rough(16)
    (step,) = rs.follow_loads(heights, grid, rs.Solid(1.0, 0.1), nominal_pressures=[0.1])
    assert step.contact.plastic_fraction == 1.0
    assert list(rs.follow_loads(heights, grid, rs.Solid(1.0, 0.1), nominal_pressures=[])) == []
