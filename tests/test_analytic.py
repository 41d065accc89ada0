"""What the theory says of a scene: the share that is used, and the sums over modes."""

from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim import analytic
from theory import partition


def sliding(scene, **changes):
    return replace(scene, sliding=replace(scene.sliding, **changes))


def test_the_share_used_is_what_the_scene_says(capped_scene):
    np.testing.assert_array_equal(analytic.heat_partition(capped_scene), 0.9)
    np.testing.assert_array_equal(analytic.heat_partition(sliding(capped_scene, heat_partition="all")), 1.0)


def test_the_rules_of_the_share_are_those_of_the_theory():
    steel = rs.load_scene("steel-1.2GPa")
    at_35 = steel.speeds.index(35.0)
    mean = analytic.heat_partition(sliding(steel, heat_partition="mean"))
    assert mean[at_35] == pytest.approx(0.9380, abs=5e-5)
    total = analytic.heat_partition(sliding(steel, heat_partition="total", duration=4.3e-4))
    expected = partition.moving_share(
        35.0,
        analytic.smoothed_spectrum(steel),
        nominal_pressure=9e7,
        effective_modulus=steel.effective_modulus,
        conductivity=30.0,
        diffusivity=30.0 / (7900 * 500),
        gamma=0.294,
        rule="total",
        duration=4.3e-4,
    )
    assert total[at_35] == pytest.approx(expected, rel=1e-12)
    assert 0.77 < total[at_35] < 0.785


def test_without_a_conducting_counterface_there_is_no_theoretical_share(capped_scene):
    alone = replace(sliding(capped_scene, heat_partition="all"), counterface=None)
    assert np.isnan(analytic.theoretical_partition(alone)).all()


def test_bodies_of_different_conductivity_share_by_it_at_rest(full_scene):
    # both at rest: s = κ₁/(κ₁ + κ₂) with κ₁ = 30 of the moving, κ₂ = 15 of the resting body
    assert analytic.theoretical_partition(full_scene)[0] == pytest.approx(2 / 3, rel=1e-9)


def test_mode_sums_approach_the_integrals_as_the_cell_grows():
    steel = rs.load_scene("steel-0.5GPa")
    whole = analytic.predictions(steel)
    spectrum = analytic.smoothed_spectrum(steel)
    errors = {}
    for waves in (1, 4, 12):
        length = waves * 2 * np.pi / 6350
        grid = rs.Grid((48 * waves, 48 * waves), (length, length))
        sums = analytic.mode_sums(steel, rs.spectrum.TruncatedSpectrum(spectrum, 1.3e5), grid)
        errors[waves] = {
            name: abs(sums[name][-1] / whole[name][-1] - 1) for name in sums if name not in ("plastic_fraction",)
        }
    for name in (
        "flash_temperature",
        "flash_gradient",
        "flash_laplacian",
        "pressure_variance",
        "correlation_radius_10",
    ):
        assert errors[4][name] < 0.003, name  # the ring of modes at q_min is coarse
        assert errors[12][name] < 0.003, name
        assert errors[1][name] > 5 * errors[12][name], name
    assert max(errors[12].values()) < 0.01


def test_the_areas_are_those_of_the_theory(capped_scene, full_scene):
    areas = analytic.area_fractions(capped_scene)
    assert 0 < areas["plastic_fraction"] < areas["contact_fraction"] < 1
    assert analytic.area_fractions(full_scene) == {"contact_fraction": 1.0, "plastic_fraction": 0.0}
