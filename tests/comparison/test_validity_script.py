"""The script that makes the map of validity: its parts give known limits, errors and functionals."""

from math import sqrt

import numpy as np
import pytest
import validity_cases  # noqa: F401  (finds the folder of the script)
from validity_map import capped, elastic, estimates, fit, members, tables

import roughsim as rs
from roughsim import prediction
from theory import calibrated, flash, persson


def test_functionals_of_one_wave_are_exact():
    # σ = p + a cos(qx): |σ_q|² = a²/2 at q; at rest the flash temperature is μ v q̇-like, Σ w/q
    grid = rs.Grid((64, 64), (2 * np.pi, 2 * np.pi))
    x = np.arange(64)[:, None] * grid.lengths[0] / 64
    stress = members.stress_table(2.0 + 0.3 * np.cos(3 * x) + np.zeros(grid.shape), grid)
    values = stress @ members.kernels(grid)
    assert values[members.COLUMNS["pressure_variance"]][0] == pytest.approx(0.045, rel=1e-12)
    even, odd = flash.angular_integrals(np.array([1.0 / 3.0]))
    assert values[members.COLUMNS["flash_temperature"]][3] == pytest.approx(0.045 / 3 * 2 / np.pi * even[0], rel=1e-12)
    assert values[members.COLUMNS["flash_gradient"]][3] == pytest.approx(-0.045 * 2 / np.pi * odd[0], rel=1e-12)


def test_the_tail_completes_a_stress_that_falls_as_the_fourth_power():
    # |σ_q|² = q^−4 from the plane up to any q: what the grid cuts off is put back
    point = elastic.Point(0.1, 0.8, 4.0)
    for pixels in (8, 16):
        grid = point.grid(4.0, pixels, 8.0)
        q = members.radial(grid).wavenumber
        stress = np.where(q > 1.0, members.radial(grid).count * (1 / 8.0) ** 2 * q**-4.0, 0.0)
        share, _ = elastic.TAIL[pixels]
        values, doubt = elastic.completed(stress, grid, pixels)
        beyond = np.pi / (elastic.CUT * grid.nyquist) ** 2
        kept = float(stress[q <= elastic.CUT * grid.nyquist].sum())
        assert values[members.COLUMNS["pressure_variance"]][0] - kept == pytest.approx(share * beyond, rel=0.02)
        assert (doubt >= 0).any()


def test_the_control_variate_leaves_the_mean_and_narrows_it():
    rng = np.random.default_rng(5)
    common = rng.standard_normal(400)
    own, other = common[:25] + 0.1 * rng.standard_normal(25), common
    shift, variance, _ = estimates._regressed(own, other)
    assert variance < 0.2 * own.var(ddof=1) / 25
    assert abs(own.mean() + shift) < 4 * sqrt(variance)


def test_gradients_of_the_quantities_are_their_derivatives():
    point = elastic.Point(0.1, 0.8, 4.0)
    q = np.geomspace(0.5, 20, 60)
    mean = (q**-2.0) @ members.kernel_matrix(q)
    for quantity in [("flash_temperature", 2), ("flash_width", 5), ("slope_length", 4), ("correlation_radius_50", 0)]:
        _, gradient = estimates.linear(mean, quantity)
        step = 1e-6 * mean * np.random.default_rng(1).standard_normal(mean.size)
        rise = estimates.linear(mean + step, quantity)[0] - estimates.linear(mean - step, quantity)[0]
        assert rise == pytest.approx(2 * gradient @ step, rel=1e-4, abs=1e-10)
    assert point.name


@pytest.mark.parametrize("point", [elastic.Point(0.02, 0.3, 16.0), elastic.Point(0.4, 1.0, 6.0, 1.0)])
def test_the_fit_uses_the_form_that_ships(point):
    c = calibrated.CONSTANTS
    flat = (c.later, c.present, *c.power, c.floor, *c.edge, *c.near)
    expected = fit.predicted(fit.Sample(point), flat)
    spectrum = persson.calibrated_spectrum(point.spectrum, effective_modulus=1.0, nominal_pressure=point.load)
    theory = estimates.theory_values(point.spectrum, point.load, stress_spectrum=spectrum)
    np.testing.assert_allclose([theory[q] for q in fit.SCORED], expected, atol=2e-4)


def test_full_contact_is_measured_as_the_theory_has_it():
    # W = 1: what is left of the ratio is the cell's few longest waves
    point = elastic.Point(12.0, 0.8, 4.0)
    raw = elastic.measure(point, elastic.Effort(0, 3, {8: 2}))
    row = tables.elastic_table([(point, raw)])
    which = [k for k, (name, _) in enumerate(row.quantities) if name in ("flash_temperature", "pressure_variance")]
    np.testing.assert_allclose(row.value[0, which], 1.0, atol=3e-3)


def ladder(power, scatter, seed=0, rungs=(4.0, 8.0, 16.0, 32.0, 64.0), exact=3.0):
    """Members with T_flash = exact (1 + f^-power) s at the cut-off f, s common to all rungs; few on the fine ones."""
    rng = np.random.default_rng(seed)
    common = np.exp(scatter * rng.standard_normal(256))
    own = {f: np.exp(0.02 * scatter * rng.standard_normal(256 // 2**k)) for k, f in enumerate(rungs)}
    raw = {}
    for f, noise in own.items():
        values = np.zeros((noise.size, members.FUNCTIONALS))
        values[:, members.COLUMNS["flash_temperature"]] = (exact * (1 + f**-power) * common[: noise.size] * noise)[
            :, None
        ]
        raw[f"capped{f:g}"] = values
    return raw


@pytest.mark.parametrize("power", [0.55, 1.0, 1.4])
def test_the_limit_of_a_ladder_has_the_exponent_that_the_ladder_shows(power):
    value, error = tables.limit(ladder(power, 1e-7), ("flash_temperature", 3))
    assert value == pytest.approx(np.log(3.0), abs=1e-5)
    assert error < 0.1 * (64.0**-power) * 1.1 + 1e-5  # nothing but the share of what lies beyond


@pytest.mark.parametrize("depth", capped.DEPTHS)
def test_where_c_ends_the_pixels_are_taken_off(depth):
    # T_flash is 0.3 n^-1.6 (4 q_y/q_max)^1.1 too high with n pixels per shortest wave; all rungs have two
    noise = 1.0 + 1e-4 * np.random.default_rng(3).standard_normal((8, 1))

    def rung(pixels, end):
        values = np.ones((8, members.FUNCTIONALS))
        values[:, members.COLUMNS["flash_temperature"]] += 0.3 * pixels**-1.6 * (4.0 / end) ** 1.1
        return values * noise

    raw = {f"capped{end:g}": rung(2, end) for end in capped.DEPTHS}
    raw |= {f"finer{n}-{end:g}": rung(n, end) for end, many in capped.FINER.items() for n in many}
    high = np.log(rung(2, depth)[0, 3] / noise[0, 0])
    shift, error = tables._pixels(raw, ("flash_temperature", 3), depth)
    assert abs(shift + high) <= error
    assert error <= 0.25 * high if depth <= 16.0 else error <= 0.6 * high


@pytest.mark.parametrize("top", [6, 8])
@pytest.mark.parametrize("power", [0.1, 0.2, 0.5])
def test_past_the_peclet_number_a_ladder_nears_its_limit_as_slow_sliding_does(power, top):
    # one variance per octave, q^-power; what the cut-off leaves out gathers at the cut-off, as the total is conserved
    q = 2.0 ** np.arange(60)
    share, kernel = q**-power, members.kernel_matrix(q)
    noise = np.random.default_rng(1).standard_normal((8, 1))
    raw = {
        f"capped{q[k]:g}": (share[:k] @ kernel[:k] + share[k:].sum() * kernel[k]) * np.exp(1e-9 * noise)
        for k in range(2, top + 1)
    }
    for speed, exact in enumerate(np.log((share @ kernel)[members.COLUMNS["flash_temperature"]])):
        value, error = tables.limit(raw, ("flash_temperature", speed))
        beyond = np.log(raw[f"capped{q[top]:g}"].mean(0)[speed]) - exact
        assert abs(value - exact) <= min(error, 0.11 * beyond) + 1e-6
        assert error <= 0.3 * beyond + 1e-6


def test_a_step_is_taken_from_where_the_coarse_rung_is_known_to_be():
    coarse = np.random.default_rng(2).standard_normal(6)
    step, slope, error = tables._step(coarse, 0.3 + 0.8 * coarse, 5.0)
    assert (step, slope) == (pytest.approx(0.3 - 0.2 * 5.0, rel=1e-9), pytest.approx(-0.2, rel=1e-9))
    assert error < 1e-9


def test_what_force_balance_fixes_on_the_finest_rungs_is_known_although_the_coarse_ones_scatter():
    raw = ladder(1.0, 0.2)
    column = members.COLUMNS["pressure_variance"]
    for k, rung in enumerate(raw.values()):
        rung[:, column] = 2.0 * (rung[:, [3]] / rung[:, 3].mean() if k == 0 else 1.0)
    value, error = tables.limit(raw, ("pressure_variance", 0))
    assert value == pytest.approx(np.log(2.0), abs=1e-2)
    assert error < 5e-3


def test_the_error_of_a_limit_covers_what_it_misses():
    found = [tables.limit(ladder(0.7, 0.1, seed), ("flash_temperature", 0)) for seed in range(40)]
    off = np.array([value - np.log(3.0) for value, _ in found])
    error = np.array([error for _, error in found])
    assert (abs(off) < error).mean() >= 0.9
    assert np.median(error) < 0.05


def test_every_capped_ladder_is_deep_enough_for_its_limit_to_be_tried():
    import validity

    for point in validity.whole_map():
        if isinstance(point, capped.CappedPoint):
            rungs = capped.ladder(point)
            assert len(rungs) >= (3 if point.label else 4), point.name
            assert list(rungs.values()) == sorted(rungs.values(), reverse=True)
            assert max(rungs) * point.yields <= point.spectrum.q_max


def test_where_a_capped_point_yields():
    point = capped.CappedPoint(0.1, 2.0)
    variance = persson.half_variance(2.0, point.spectrum, effective_modulus=1.0)
    from theory import plasticity

    _, left, yielded = plasticity.area_fractions(variance, 0.1 * point.hardness, point.hardness)
    assert left / (left + yielded) == pytest.approx(0.01, rel=1e-9)
    scene = rs.load_scene("steel-1.2GPa")
    assert capped.of_scene(scene).yields * 9.4e4 == pytest.approx(prediction.yield_wavenumber(scene), rel=1e-9)
