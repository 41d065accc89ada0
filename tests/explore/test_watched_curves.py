"""The curves over the sliding speed and the distance: means with their errors, and the theory."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import j0

import roughsim as rs
from roughsim import prediction
from roughsim.estimate.errors import quantile
from roughsim.explore import content as curves


def test_measured_curves_are_the_estimates(capped_run):
    for column in ("smoothed", "capped"):
        found = curves.measured_curves(capped_run, column)
        for name in curves.OVER_SPEED:
            estimate = capped_run.estimate(name, column)
            np.testing.assert_array_equal(
                found[name].coords["speed"], [0.1, 35.0]
            )  # rest has no place on a log axis
            np.testing.assert_array_equal(found[name].mean, estimate.mean[1:])
            np.testing.assert_array_equal(found[name].total_error, estimate.total_error[1:])
        curve = found[curves.CORRELATION]
        r = curve.coords["distance"]
        lowest, *steps = capped_run.samples(column)
        terms = [
            (1.0, lowest),
            *((1.0, step) for step in steps),
            *((-1.0, step.below) for step in steps),
        ]
        exact = sum(
            sign * sample.spectrum.mean(0) @ j0(np.outer(sample.wavenumber, r[[0, 40, -1]]))
            for sign, sample in terms
        )
        np.testing.assert_allclose(curve.mean[[0, 40, -1]], exact, rtol=1e-9, atol=1e-9 * exact[0])
        narrow, wide = (
            quantile(freedom) for freedom in (5.0 * len(steps) + 5.0, 5.0)
        )  # six of each level
        standard = capped_run.correlation(r, column)[1]
        assert np.all(curve.total_error >= narrow * standard * (1 - 1e-9))
        assert np.all(curve.total_error <= wide * standard * (1 + 1e-9))


def test_theory_curves_pass_through_the_predictions_with_the_share(capped_run):
    found, scene = curves.theory_curves(capped_run), capped_run.scene
    whole = prediction.predictions(scene)
    for name in curves.OVER_SPEED:
        x, line, law = found[name]
        share = 0.9 if name == "flash_temperature" else 1.0
        at = np.exp(np.interp(np.log([0.1, 35.0]), np.log(x), np.log(line)))
        np.testing.assert_allclose(
            at, share * whole[name][1:], rtol=2e-3
        )  # interpolated between 20 points a decade
        if name == "flash_temperature":
            law = np.exp(np.interp(np.log(35.0), np.log(x), np.log(law)))
            exact = rs.theory(scene).to_dict()["calibrated"][name][-1]
            assert law == pytest.approx(exact, rel=2e-3)
    r, line, _ = found[curves.CORRELATION]
    q = np.geomspace(scene.spectrum.breaks[0], scene.spectrum.breaks[-1], 20_001)
    density = 2 * np.pi * q**2 * prediction.stress_spectrum(scene, q)
    for k in (0, 80, -1):  # g_σ(r) = 2π ∫ q |σ_q|² J₀(qr) dq, by trapezoids over ln q
        exact = np.trapezoid(density * j0(q * r[k]), np.log(q))
        assert line[k] == pytest.approx(exact, rel=1e-4, abs=1e-5 * whole["pressure_variance"][0])


def test_distances_begin_at_a_tenth_of_the_shortest_wave(capped_run):
    r = curves.measured_curves(capped_run, "capped")[curves.CORRELATION].coords["distance"]
    longest, shortest = (2 * np.pi / capped_run.scene.spectrum.breaks[k] for k in (0, -1))
    assert (r[0], r[-1]) == pytest.approx((0.1 * shortest, 0.4 * longest))
    np.testing.assert_allclose(np.diff(np.log(r)), np.log(r[-1] / r[0]) / 159)


def test_speeds_reach_a_decade_beyond_the_scene(capped_scene):
    assert curves.speed_range(capped_scene) == pytest.approx((1e-2, 1e3))
    resting = replace(capped_scene, sliding=replace(capped_scene.sliding, speed=(0.0,)))
    assert curves.speed_range(resting) == pytest.approx((0.1, 10.0))
