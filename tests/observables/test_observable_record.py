"""A record of an observable: what the theory says of it, the rows of a sample, and ratios of means."""

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.record import Observable, Sample, TheoryOfScene, ratio
from roughsim.observables.stress_spectrum import StressSpectrum
from roughsim.prediction.modes import summed_over_modes
from roughsim.prediction.theories import calibrated_integrals, integrals

THEORY = TheoryOfScene(
    {"slope_length": np.array([1.0, 2.0, 3.0])},
    9e7,
    correlation_radius=lambda f: 10.0 * f,
    total=lambda w: 0.0,
)


def test_the_theory_of_an_observable_is_its_own_or_the_value_of_its_name_or_nothing():
    own = Observable("own", "m", theory=lambda theory: theory.correlation_radius(0.5))
    np.testing.assert_array_equal(own.of_theory(THEORY, 3), [5.0])
    np.testing.assert_array_equal(
        Observable("slope_length", "m").of_theory(THEORY, 3), [1.0, 2.0, 3.0]
    )
    np.testing.assert_array_equal(Observable("other", "m").of_theory(THEORY, 3), [np.nan])
    np.testing.assert_array_equal(
        Observable("other", "m", per_speed=True).of_theory(THEORY, 3), [np.nan] * 3
    )


def test_a_ratio_of_means_has_its_value_also_where_its_scatter_is_undefined():
    below = np.array([[1.0], [3.0]])
    np.testing.assert_array_equal(ratio(np.zeros((2, 1)), below), [[0.0], [0.0]])
    np.testing.assert_array_equal(ratio(below, np.zeros((2, 1))), [[np.inf], [np.inf]])
    # d(√(a/b)) = √(a/b)/2 · (da/a − db/b)
    assert ratio(below, np.array([[4.0], [4.0]]), 0.5).ravel() == pytest.approx(
        [np.sqrt(0.5) * x for x in (0.75, 1.25)]
    )


def test_the_theory_of_an_observable_may_divide_by_the_load():
    concentration = Observable(
        "concentration",
        "1",
        theory=lambda theory: theory.total(np.ones_like) / theory.nominal_pressure,
    )
    scene = rs.load_scene("demo")
    views = integrals(scene), calibrated_integrals(scene)
    views += (
        summed_over_modes(
            scene, prediction.smoothed_spectrum(scene), rs.Grid((256, 256), (4e-3, 4e-3))
        ),
    )
    for view in views:
        assert concentration.of_theory(view, 1) == pytest.approx(
            view.total(np.ones_like) / 90e6, rel=1e-12
        )


@pytest.mark.parametrize("hardness", [np.inf, 0.1])
@pytest.mark.parametrize("tolerance", [1e-2, pytest.param(1e-3, marks=pytest.mark.slow), 1e-4])
def test_the_contact_solve_changes_the_mean_of_each_observable_by_no_more_than_its_share_of_the_tolerance(
    hardness, tolerance
):
    grid = rs.Grid((192, 192), (1.0, 1.0))
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        0.3, hurst=0.8, q_min=2 * np.pi, q_roll_off=8 * np.pi, q_max=40 * np.pi
    )
    sliding = rs.HeatSource(
        [0.1, 10.0, 1e3], friction_coefficient=0.1, conductivity=1.0, diffusivity=1.0
    )

    def measured(heights, precise):
        contact = rs.solve_contact(
            heights, grid, rs.Solid(1.0, hardness), nominal_pressure=0.005, tolerance=precise
        )
        moments = rs.measure(contact, grid, sliding)
        radii = {
            f"correlation_radius_{k}": moments.stress_spectrum.correlation_radius(k / 100)
            for k in (50, 10, 0)
        }
        direct = [name for name in OBSERVABLES if hasattr(moments, name)]
        return radii | {name: getattr(moments, name) for name in direct}

    changes = {}
    for seed in range(6):
        heights = rs.synthesize(spectrum, grid, np.random.default_rng(seed))
        exact, found = measured(heights, 1e-9), measured(heights, tolerance)
        for name, value in exact.items():
            pixel = (
                1.0 / grid.points if name.endswith("_fraction") else 0.0
            )  # areas change by whole pixels
            change = np.maximum(abs(found[name] - value) - pixel, 0.0) * np.sign(
                found[name] - value
            )
            changes.setdefault(name, []).append(
                change / np.where(value == 0.0, 1.0, abs(value)) / tolerance
            )
    assert len(changes) >= 11
    for name, change in changes.items():
        assert np.all(abs(np.mean(change, axis=0)) <= OBSERVABLES[name].solver_share), name


@pytest.mark.parametrize("seed", range(5))
def test_radii_are_those_that_a_search_from_the_origin_finds_in_whatever_order_they_are_asked_for(
    seed,
):
    rng = np.random.default_rng(seed)
    q = np.sort(rng.uniform(1.0, 300.0, 200))
    spectrum = rng.random((7, 200)) / q**1.5
    for order in ((50, 10, 0), (0, 10, 50)):
        sample = Sample(300.0, 64.0, np.arange(7), {}, q, spectrum, 3.0)
        for percent in order:
            found = OBSERVABLES[f"correlation_radius_{percent}"].of_level(sample).mean()
            expected = StressSpectrum(q, spectrum.mean(axis=0), 3.0).correlation_radius(
                percent / 100
            )
            assert found == pytest.approx(expected, rel=1e-11, nan_ok=True)
    # one that never falls to half has none of the others
    flat = Sample(300.0, 64.0, np.arange(7), {}, q, spectrum * (q < 1.5 * q[0]), 1e-6)
    assert np.isnan(OBSERVABLES["correlation_radius_0"].of_level(flat)).all()
