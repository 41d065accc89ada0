"""What the theory says of a scene: the share that is used, and the sums over modes."""

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import erf
from soft_scene import RUBBER

import roughsim as rs
from roughsim import prediction
from roughsim.prediction.modes import summed_over_modes
from roughsim.prediction.stress import stress_arguments
from roughsim.prediction.theories import integrals
from roughsim.surface.spectrum import TruncatedSpectrum
from theory import flash, partition, persson


def sliding(scene, **changes):
    return replace(scene, sliding=replace(scene.sliding, **changes))


def test_the_share_used_is_what_the_scene_says(capped_scene):
    np.testing.assert_array_equal(prediction.heat_partition(capped_scene), 0.9)
    np.testing.assert_array_equal(
        prediction.heat_partition(sliding(capped_scene, heat_partition="all")), 1.0
    )


def test_the_rules_of_the_share_are_those_of_the_theory():
    steel = rs.load_scene("steel-1.2GPa")
    at_35 = steel.speeds.index(35.0)
    mean = prediction.heat_partition(sliding(steel, heat_partition="mean"))
    assert mean[at_35] == pytest.approx(0.9380, abs=5e-5)
    total = prediction.heat_partition(sliding(steel, heat_partition="total", duration=4.3e-4))
    expected = partition.moving_share(
        35.0,
        prediction.smoothed_spectrum(steel),
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


def different_bodies(scene, **changes):
    other = {"like": None, "conductivity": 12.0, "density": 2700.0, "heat_capacity": 900.0}
    return sliding(replace(scene, counterface=replace(scene.counterface, **other)), **changes)


def test_the_total_temperatures_of_two_different_bodies_agree_in_theory_and_over_the_modes():
    # s (τ₂ + T₂) = (1 − s)(τ₁ + T₁(t)), each side with all the heat and written out here
    steel = different_bodies(rs.load_scene("steel-1.2GPa"), heat_partition="total", duration=1e-3)
    spectrum, length = prediction.smoothed_spectrum(steel), 6 * 2 * np.pi / 6350
    stress = {
        "effective_modulus": steel.effective_modulus,
        "nominal_pressure": 9e7,
        "gamma": 0.294,
    }
    heat = {
        "friction_coefficient": 0.11,
        "conductivity": 30.0,
        "diffusivity": steel.conduction().diffusivity,
    }
    moving = flash.flash_temperature(35.0, spectrum, **stress, **heat)
    moving += 2 * 0.11 * 9e7 * 35 / 30 * np.sqrt(steel.conduction().diffusivity * 1e-3 / np.pi)
    spread = np.sqrt(12 / (2700 * 900) * 1e-3)
    nodes, weights = np.polynomial.legendre.leggauss(120)
    pieces = []
    for low, high in pairwise(np.log(spectrum.breaks)):
        q = np.exp(0.5 * (high - low) * nodes + 0.5 * (high + low))
        density = 2 * np.pi * prediction.stress_spectrum(steel, q) * erf(q * spread)
        pieces.append(0.5 * (high - low) * weights @ (density * q))
    resting = 0.11 * 35 / (12 * 9e7) * sum(pieces) + 2 * 0.11 * 9e7 * 35 / 12 * spread / np.sqrt(
        np.pi
    )
    expected, k = resting / (resting + moving), steel.speeds.index(35.0)
    assert prediction.heat_partition(steel)[k] == pytest.approx(expected, rel=1e-6)
    assert prediction.predictions(steel)["heat_partition"][k] == pytest.approx(expected, rel=1e-6)
    drawn = TruncatedSpectrum(spectrum, 1.9e5)
    summed = prediction.mode_sums(steel, drawn, rs.Grid((384, 384), (length, length)))
    assert summed["heat_partition"][k] == pytest.approx(expected, rel=5e-3)


def test_without_a_conducting_counterface_there_is_no_theoretical_share(capped_scene):
    alone = replace(sliding(capped_scene, heat_partition="all"), counterface=None)
    assert np.isnan(prediction.predictions(alone)["heat_partition"]).all()


def test_bodies_of_different_conductivity_share_by_it_at_rest(full_scene):
    # both at rest: s = κ₁/(κ₁ + κ₂) with κ₁ = 30 of the moving, κ₂ = 15 of the resting body
    assert prediction.predictions(full_scene)["heat_partition"][0] == pytest.approx(2 / 3, rel=1e-9)


def test_a_cut_surface_that_yields_at_once_has_the_stress_of_the_whole_one(capped_scene):
    # all is plastic within 1e-11 of q_min: C_sm must be told how far above q_min a wavenumber lies, cut or not
    soft = replace(capped_scene, surface=replace(capped_scene.surface, rms_height=30.0))
    smoothed = prediction.smoothed_spectrum(soft)
    assert smoothed.breaks[-3] / smoothed.breaks[0] - 1 < 1e-9
    cut = TruncatedSpectrum(smoothed, 1.5 * smoothed.breaks[0])
    stress = stress_arguments(soft)
    whole, part = (
        float(persson.pressure_correlation(0.0, each, **stress)) for each in (smoothed, cut)
    )
    assert part == pytest.approx(whole, rel=1e-11)
    assert prediction.predictions(soft)["flash_width"] == pytest.approx(
        1 / soft.surface.q_min, rel=1e-9
    )


def test_mode_sums_approach_the_integrals_as_the_cell_grows():
    steel = rs.load_scene("steel-0.5GPa")
    whole = prediction.predictions(steel)
    spectrum = prediction.smoothed_spectrum(steel)
    errors = {}
    for waves in (1, 4, 12):
        length = waves * 2 * np.pi / 6350
        grid = rs.Grid((48 * waves, 48 * waves), (length, length))
        sums = prediction.mode_sums(steel, TruncatedSpectrum(spectrum, 1.3e5), grid)
        errors[waves] = {
            name: abs(sums[name][-1] / whole[name][-1] - 1)
            for name in sums
            if name not in ("plastic_fraction",)
        }
    for name in (
        "flash_temperature",
        "flash_gradient",
        "flash_laplacian",
        "pressure_variance",
        "correlation_radius_10",
    ):
        assert errors[4][name] < 0.01, name  # the ring of modes at q_min is coarse
        assert errors[12][name] < 0.003, name
        assert errors[1][name] > 5 * errors[12][name], name
    assert max(errors[12].values()) < 0.01


FIRST = 2 * np.pi / 1e-3  # rad/m


@pytest.fixture
def wide():
    """Two elastic faces with waves of 400 mode spacings of a cell of 1 mm; C(q) jumps at the end of one of them."""
    body = {
        "youngs_modulus": 2e11,
        "poisson_ratio": 0.3,
        "conductivity": 30.0,
        "density": 7900.0,
        "heat_capacity": 500.0,
    }
    face = {"hurst": 0.7, "q_min": FIRST, "rms_height": 5e-7}
    return rs.load_scene(
        {
            "surface": face | {"q_max": 400 * FIRST},
            "body": body,
            "counterface": face | body | {"q_max": 200.3 * FIRST, "conductivity": 10.0},
            "sliding": {
                "nominal_pressure": 5e7,
                "friction_coefficient": 0.2,
                "speed": [1e-3, 0.1, 10.0],
            },
        }
    )


@pytest.mark.parametrize("sides", [pytest.param((1.0, 1.0), marks=pytest.mark.slow), (2.0, 1.0)])
def test_rings_of_dense_modes_sum_as_the_modes_in_them(wide, sides, monkeypatch):
    lengths = tuple(side * 1e-3 for side in sides)
    grid = rs.Grid(tuple(int(820 * side) for side in sides), lengths)
    by_rings = summed_over_modes(wide, wide.spectrum, grid)
    wavenumber = by_rings.correlation_radius.__self__.wavenumber
    assert wavenumber.size < 20_000
    assert np.all(np.diff(wavenumber) > 0.0)
    monkeypatch.setattr("roughsim.prediction.modes._DENSE", np.inf)
    by_modes = summed_over_modes(wide, wide.spectrum, grid)
    for name in ("flash_temperature", "flash_gradient", "flash_laplacian", "heat_partition"):
        np.testing.assert_allclose(
            by_rings.values[name], by_modes.values[name], rtol=2e-5, err_msg=name
        )
    radius = np.linspace(0.0, 0.5 * np.hypot(*lengths), 50)
    rings, modes = (
        sums.correlation_radius.__self__.pressure_correlation(radius)
        for sums in (by_rings, by_modes)
    )
    np.testing.assert_allclose(rings, modes, atol=3e-5 * modes[0])


def test_modes_on_a_line_have_no_rings(wide):
    line = prediction.mode_sums(wide, wide.spectrum, rs.Grid((1, 820), (1e-3, 1e-3)))
    plane = prediction.mode_sums(wide, wide.spectrum, rs.Grid((820, 820), (1e-3, 1e-3)))
    assert 0 < line["pressure_variance"] < 0.1 * plane["pressure_variance"]


def test_a_density_that_is_negative_in_rings_is_refused(wide):
    class Odd:
        breaks = wide.spectrum.breaks

        def __call__(self, q):
            return np.where(np.abs(q / FIRST - 350.5) < 0.4, -1.0, 1.0) * wide.spectrum(q)

    with pytest.raises(ValueError, match="must be finite and not negative"):
        prediction.mode_sums(wide, Odd(), rs.Grid((820, 820), (1e-3, 1e-3)))


def test_a_grid_too_coarse_for_the_modes_is_refused(wide):
    with pytest.raises(rs.ResolutionError, match=r"exceeds the Nyquist wavenumber .* \(780, 780\)"):
        prediction.mode_sums(wide, wide.spectrum, rs.Grid((780, 780), (1e-3, 1e-3)))


def test_the_areas_are_those_of_the_theory(capped_scene, full_scene):
    areas = prediction.area_fractions(capped_scene)
    assert 0 < areas["plastic_fraction"] < areas["contact_fraction"] < 1
    assert prediction.area_fractions(full_scene) == {
        "contact_fraction": 1.0,
        "plastic_fraction": 0.0,
    }


def test_totals_over_the_stress_spectrum_are_its_integrals():
    steel = rs.load_scene("steel-2.0GPa")
    nodes, weights = np.polynomial.legendre.leggauss(400)
    y = 0.5 * (1.0 + nodes)  # ln q ∝ y²: contact is lost in a layer just above the first wavenumber
    expected = np.zeros(3)
    for low, high in pairwise(np.log(prediction.smoothed_spectrum(steel).breaks)):
        q = np.exp(low + (high - low) * y**2)
        area = np.pi * weights * (high - low) * 2.0 * y * q**2  # 2π q dq
        expected += [
            (area * prediction.stress_spectrum(steel, q)) @ q**power for power in (-1.0, 0.0, 1.0)
        ]
    found = [integrals(steel).total(lambda q, power=power: q**power) for power in (-1.0, 0.0, 1.0)]
    np.testing.assert_allclose(found, expected, rtol=1e-8)


def test_totals_over_the_modes_of_a_cell_are_those_of_its_moments():
    # at v → 0 T_flash = (μv/κσ₀) Σ |σ_q|²/q
    steel = sliding(rs.load_scene("steel-2.0GPa"), speed=(1e-9,))
    grid = rs.Grid((128, 128), (4e-3, 4e-3))
    sums = summed_over_modes(
        steel, TruncatedSpectrum(prediction.smoothed_spectrum(steel), 9e4), grid
    )
    rate = (
        steel.sliding.friction_coefficient
        * 1e-9
        / (steel.body.conductivity * steel.sliding.nominal_pressure)
    )
    assert sums.values["flash_temperature"][0] == pytest.approx(
        rate * sums.total(lambda q: 1 / q), rel=1e-9, abs=0
    )


@pytest.mark.parametrize("hardness", [None, 10e9])
def test_the_theory_up_to_a_cut_off_is_that_of_a_surface_that_ends_there(hardness):
    rock = rs.load_scene("granite")
    rock = replace(rock, body=replace(rock.body, penetration_hardness=hardness))
    ends = rock.spectrum.truncated(q_max=4e5)
    short = replace(
        rock, surface=replace(rock.surface, q_max=4e5, rms_height=ends.rms_height / np.sqrt(2.0))
    )
    cut, whole = prediction.predictions(rock, 4e5), prediction.predictions(short)
    for name, values in whole.items():
        np.testing.assert_allclose(cut[name], values, rtol=1e-6, err_msg=name)
    np.testing.assert_allclose(
        prediction.predictions(rock, np.inf)["flash_temperature"],
        prediction.predictions(rock)["flash_temperature"],
        rtol=1e-12,
    )


def test_yielded_contact_falls_the_slower_the_rougher_its_short_waves():
    def falls(hurst, end=2e6, q_c=3e5):
        spectrum = rs.SelfAffineSpectrum.from_rms_height(
            1e-6, hurst=hurst, q_min=1e4, q_roll_off=2e4, q_max=end
        )
        return prediction.usual_exponent(SimpleNamespace(spectrum=spectrum), q_c)

    assert falls(0.3) == pytest.approx(0.3 + 1.05 * 0.3, rel=1e-9)
    assert falls(0.0) == pytest.approx(0.3, rel=1e-9)
    assert falls(0.8) == 1.0
    assert falls(0.3, end=3e5) == 1.0  # nothing follows
    assert (
        falls(0.3, end=3e5 * (1 + 1e-15)) == 1.0
    )  # nor where a map's last wave and its cut-off differ by rounding
    # H is that of the next sixteen-fold of q: flat for a factor 2, then q^−3.2 for a factor 8, is H = 0.2
    assert falls(0.6, q_c=1e4) == pytest.approx(0.3 + 1.05 * 0.2, rel=1e-9)
    assert falls(0.3, q_c=1e4) == pytest.approx(0.3, rel=1e-9)  # less than none counts as none


@pytest.mark.parametrize(
    (
        "exponents",
        "follows",
    ),  # of C(q) from 1e3, 1e4, 2e4, 4e4, 8e4, 1.6e5, 3.2e5 and 6.4e5 on, to 1e7
    [
        ([3.6] * 8, True),
        ([0.0] + [3.6] * 7, True),  # a plateau below
        ([3.6] * 7 + [8.0], True),  # far beyond hardly anything follows
        ([3.4, 3.4, 3.5, 3.6, 3.7, 3.8, 3.9, 3.9], True),
        ([3.6, 3.6, 3.6, 4.2, 4.2, 4.2, 4.2, 4.2], False),
        ([3.6, 3.6, 3.6, 3.6, 3.6, 3.6, 4.2, 4.2], False),
        ([0.0, 3.0, 3.6, 3.6, 3.6, 3.6, 3.6, 3.6], False),
        ([3.3, 3.4, 3.5, 3.6, 3.7, 3.8, 3.95, 3.95], False),  # by .55 in all
        ([3.6, 4.2, 3.6, 3.6, 3.6, 3.6, 3.6, 3.6], None),
        ([3.6, 3.6, 4.2, 3.6, 3.6, 3.6, 3.6, 3.6], None),
        ([3.6, 3.6, 3.6, 3.6, 3.6, 3.6, 3.0, 3.0], None),
        ([3.95, 3.9, 3.8, 3.7, 3.6, 3.5, 3.35, 3.35], None),
    ],
)
def test_a_spectrum_follows_a_power_if_it_falls_alike_below_and_above_the_cut_off(
    exponents, follows
):
    q = np.array([1e3, 1e4, 2e4, 4e4, 8e4, 1.6e5, 3.2e5, 6.4e5, 1e7])
    psd = np.exp(np.concatenate([[0.0], np.cumsum(-np.array(exponents) * np.diff(np.log(q)))]))
    scene = SimpleNamespace(spectrum=rs.TabulatedSpectrum(q, psd))
    assert prediction.follows_power(scene, (5e3, 1e4, 2e4, 4e4)) is follows


@pytest.mark.parametrize(
    ("steps", "follows"), [((3.6, 3.6), True), ((3.6, 20.0), False), ((3.6, -2.0), None)]
)
def test_the_last_part_of_an_octave_of_the_spectrum_is_seen(steps, follows):
    q = np.array([1e4, 8e4, 1.59e5])  # the end is just below two octaves above the cut-off
    psd = np.exp(np.concatenate([[0.0], np.cumsum(-np.array(steps) * np.diff(np.log(q)))]))
    assert (
        prediction.follows_power(SimpleNamespace(spectrum=rs.TabulatedSpectrum(q, psd)), (2e4, 4e4))
        is follows
    )


def test_a_spectrum_with_a_gap_follows_no_power():
    low, high = (
        rs.SelfAffineSpectrum.from_rms_height(1e-6, hurst=0.8, q_min=q, q_max=6 * q)
        for q in (1e4, 1e5)
    )
    scene = SimpleNamespace(spectrum=low + high)  # none from 6e4 to 1e5/m
    assert prediction.follows_power(scene, (2e4, 4e4)) is None


def test_who_yields_beyond_the_cut_off_does_not_follow_the_theory_and_who_has_yielded_falls():
    rock, rubber, steel = (rs.load_scene(name) for name in ("granite", RUBBER, "steel-1.2GPa"))
    assert prediction.follows_theory(rubber, "elastic", (3e4,)) is True
    assert prediction.follows_theory(rock, "smoothed", (4e5,)) is True
    assert (
        prediction.follows_theory(rock, "capped", (4e5,)) is None
    )  # 97 % of it yields up to q_max
    hard = replace(rock, body=replace(rock.body, penetration_hardness=30e9))
    assert prediction.follows_theory(hard, "capped", (4e5,)) is True
    assert prediction.follows_theory(steel, "capped", (4e5,)) is False
    assert prediction.continuation(steel, "capped", (2e5, 4e5), "flash_temperature") is None
    assert np.isnan(prediction.continuation(rock, "capped", (2e5, 4e5), "flash_temperature")).all()
    found = prediction.continuation(rubber, "elastic", (2e4, 4e4), "flash_temperature")
    assert found.shape == (3, 5)
    assert np.all(np.diff(found, axis=0) > 0)


def test_elastic_contact_of_any_bandwidth_follows_the_law_and_one_of_too_light_load_does_not():
    rock, rubber = rs.load_scene("granite"), rs.load_scene(RUBBER)
    q = 2e4, 4e4
    assert prediction.calibrated(rubber).stress_spectrum is None  # too light a load
    found = prediction.calibrated_flash(rubber, "elastic", q)
    assert found.shape == (3, 5)
    theory = prediction.continuation(rubber, "elastic", q, "flash_temperature")
    assert np.all(np.diff(found, axis=0) > 0.0)
    assert np.all(found[2, :2] / found[1, :2] < theory[2, :2] / theory[1, :2])  # slow sliding
    pressed = replace(rubber.sliding, nominal_pressure=0.1 * rubber.sliding.nominal_pressure)
    assert prediction.calibrated_flash(replace(rubber, sliding=pressed), "elastic", q) is None
    assert prediction.calibrated_flash(rock, "capped", (2e5, 4e5)) is None
    assert prediction.calibrated_flash(rock, "smoothed", (2e5, 4e5)) is None


@pytest.mark.parametrize(
    ("before", "now", "at_the_end", "follows", "bounded"),
    [
        (0.0, 0.0, 0.0, True, True),
        (0.02, 0.03, 0.049, True, True),
        (0.02, 0.03, 0.051, None, None),
        (0.49, 0.6, 0.65, None, None),
        (0.51, 0.6, 0.65, None, False),  # between the rise and the fall is a maximum
        (0.98, 0.999, 1.0, None, False),  # the last step of the ladder goes over it
        (0.989, 0.999, 1.0, None, False),
        (0.991, 0.999, 1.0, False, False),
    ],
)
def test_contact_follows_the_theory_if_less_than_5_percent_yields_and_falls_if_both_ends_of_a_step_have_yielded(
    monkeypatch, before, now, at_the_end, follows, bounded
):
    shares = {2e5: before, 4e5: now, np.inf: at_the_end}

    def areas(scene, q_max=np.inf):
        return {"contact_fraction": 0.2, "plastic_fraction": 0.2 * shares[q_max]}

    monkeypatch.setattr("roughsim.prediction.areas.area_fractions", areas)
    rock = rs.load_scene("granite")
    assert prediction.follows_theory(rock, "capped", (1e5, 2e5, 4e5)) is follows
    assert prediction.follows_theory(rock, "smoothed", (1e5, 2e5, 4e5)) is True
    names = (
        "contact_fraction",
        "plastic_fraction",
        "pressure_variance",
    )  # what tends to a bound, from half on
    theory = dict.fromkeys(names, np.ones(1))
    monkeypatch.setattr(
        "roughsim.prediction.cut_offs.predictions", lambda scene, q_max=np.inf: theory
    )
    for name in names:
        found = prediction.continuation(rock, "capped", (1e5, 2e5, 4e5), name)
        assert bounded is (False if found is None else True if np.isfinite(found).all() else None)
