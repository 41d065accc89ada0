"""Contact that yields, continued by a law of it: right where the law is, refuted by the rungs where it is not."""

from dataclasses import replace

import numpy as np
import pytest
from ladder_cases import NAME, level

import roughsim as rs
from roughsim import prediction
from roughsim.estimate import ladder
from roughsim.estimate.continuation import Rung, doubt_of_law, the_surer
from roughsim.estimate.ladder import notes_of, observe, values_of
from roughsim.scene.numerics import Level, Numerics
from theory import flash, plasticity

CUT_OFFS, END = (4.0, 8.0, 16.0), 800.0


def fall(q):
    """T_flash that falls faster below than any power of its last steps."""
    return 7.0 * (1.0 + 1.4 * np.asarray(q) ** -1.1 + 2.0 * np.asarray(q) ** -3.0)


def observed(truth, law, *, count=3, scatter=0.0, every=1):
    """Levels of 40 realizations with these means, with a law or without; the fine ones for one in `every`."""
    rng = np.random.default_rng(3)
    common, samples = scatter * rng.standard_normal((40, 1)), []
    for k, q in enumerate(CUT_OFFS[-count:]):
        own = common + 0.1 * scatter * rng.standard_normal((40, 1))
        rows = np.arange(0, 40, every if k else 1)
        samples.append(level((truth(q) * (1.0 + own - own.mean()))[rows], q_max=q, side=64.0 * q, rows=rows))
    table = None if law is None else law(np.array([*CUT_OFFS[-2:], END]))[:, None]
    return observe(NAME, samples, capped=True, end=END, settled=4.0, law=table)


@pytest.mark.parametrize("count", [2, 3])
def test_a_law_right_but_for_a_factor_gives_the_limit(count):
    values, without = (observed(lambda q: 1.03 * fall(q), law, count=count) for law in (fall, None))
    limit, follows = 1.03 * fall(END), 1.03 * (fall(16.0) - fall(END))
    if count == 2:
        assert values.extrapolated.mean() == pytest.approx(limit, rel=1e-12)
        assert values.bandwidth[0] == pytest.approx(np.hypot(0.005 * 1.03 * fall(16.0), 0.07 * follows), rel=1e-9)
        assert np.isnan(values.exponent[0])
    assert abs(values.extrapolated.mean() - limit) <= values.bandwidth[0] <= without.bandwidth[0]


def test_where_little_follows_a_part_of_it_is_in_doubt_and_no_share_of_the_value():
    top = np.full((13, 2), 100.0)
    rungs = [Rung(level(rows), rows) for rows in (top, top)]
    law = np.array([[1.0, 1.0], [1.0, 1.0], [0.99, 1.04]])  # −1 % follows, and 4 %: there 0.5 % of the value is less
    power = np.ones(2), np.array([[-1.0, 4.0]] * 13), np.full(2, 5.0)
    _, remainder, stated = the_surer(power, rungs, law)
    np.testing.assert_allclose(remainder.mean(axis=0), [-1.0, 4.0], rtol=1e-9)
    np.testing.assert_allclose(stated, [np.hypot(0.15, 0.07), np.hypot(0.5, 0.07 * 4.0)], rtol=1e-9)


def test_the_doubt_of_the_law_has_no_sign():
    value, follows, change = np.array([100.0, -100.0]), np.array([-1.0, 1.0]), np.array([-0.3, 0.3])
    np.testing.assert_allclose(doubt_of_law(value, follows, change), np.linalg.norm([0.15, 0.07, 0.3]), rtol=1e-12)
    np.testing.assert_allclose(doubt_of_law(value, 9.0 * follows, change), np.linalg.norm([0.5, 0.63, 0.3]), rtol=1e-12)


def test_what_measured_over_law_changes_over_the_last_step_is_in_doubt():
    def drifting(q):
        return (1.0 + 0.08 / np.asarray(q)) * fall(q)  # by .5 % from 8 to 16, by as much again beyond

    values = observed(drifting, fall, count=2)
    change = drifting(16.0) * fall(8.0) / fall(16.0) - drifting(8.0)
    by_law = drifting(16.0) * fall(END) / fall(16.0)
    assert values.extrapolated.mean() == pytest.approx(by_law, rel=1e-12)
    doubts = 0.005 * drifting(16.0), 0.07 * (drifting(16.0) - by_law), change
    assert values.bandwidth[0] == pytest.approx(np.linalg.norm(doubts), rel=1e-9)
    assert abs(drifting(END) - by_law) <= values.bandwidth[0]


def test_the_worst_speed_counts_for_all():
    samples = [level(np.full((13, 2), fall(q)), q_max=q, side=64.0 * q) for q in CUT_OFFS[-2:]]
    q = np.array([*CUT_OFFS[-2:], END])
    table = np.stack([fall(q), (1.0 + 0.08 / q) * fall(q)], axis=1)
    bandwidth = observe(NAME, samples, capped=True, end=END, law=table).bandwidth
    alone = observed(fall, fall, count=2).bandwidth[0]
    assert bandwidth[0] == pytest.approx(np.hypot(alone, fall(8.0) * (1.01 / 1.005 - 1.0)), rel=1e-9)


def test_a_speed_at_rest_says_nothing_of_the_others():
    samples = [level(np.full((13, 2), fall(q)) * [0.0, 1.0], q_max=q, side=64.0 * q) for q in CUT_OFFS[-2:]]
    table = np.stack([np.zeros(3), fall(np.array([*CUT_OFFS[-2:], END]))], axis=1)
    values = observe(NAME, samples, capped=True, end=END, law=table)
    assert values.extrapolated[:, 1].mean() == pytest.approx(fall(END), rel=1e-12)
    assert values.bandwidth[1] == pytest.approx(observed(fall, fall, count=2).bandwidth[0], rel=1e-12)


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("power", [0.2, -0.2])
def test_the_rungs_refute_a_law_that_is_wrong_by_a_power(count, power):
    values, without = (observed(fall, law, count=count, scatter=0.005) for law in (lambda q: fall(q) * q**power, None))
    np.testing.assert_array_equal(values.extrapolated, without.extrapolated)
    assert values.bandwidth[0] >= max(without.bandwidth[0], abs(values.extrapolated.mean() - fall(END)))


@pytest.mark.parametrize("power", [0.02, -0.02, 0.01, -0.01])
def test_a_law_that_is_wrong_by_little_at_each_step_is_told_by_its_distance_from_the_fit(power):
    values = observed(fall, lambda q: fall(q) * q**power)
    assert abs(values.extrapolated.mean() - fall(END)) <= values.bandwidth[0]


def test_scatter_alone_does_not_refute_a_law():
    # few fine realizations fit an exponent that leads anywhere; the ratio to the law does not scatter
    values = observed(fall, fall, scatter=0.05, every=8)
    assert np.isnan(values.exponent[0])
    assert values.bandwidth[0] < 0.03 * fall(END)


@pytest.mark.parametrize(
    ("distance", "scatter", "error", "chosen", "expected"),
    [
        (0.0, 0.0, 2.0, True, 1.0),  # the law: 0.5 % of 100 and 7 % of the 12.37 that follow, and no change
        (0.0, 0.0, 0.9, False, 0.9),  # the power is surer
        (0.0, 0.1, 0.9, False, 0.9),  # with what its scatter adds: t = 3.18 for four rows, 0.9² + 0.318² < 1
        (0.0, 0.2, 0.9, True, 1.0),  # 0.9² + 0.636² > 1
        (3.0, 0.0, 2.0, False, 3.0),  # 3 > √(1 + 4): one of the two is wrong
        (2.0, 0.0, 2.0, True, 1.0),
        (2.1, 0.0, 2.0, True, 1.0),  # 2 < 2.1 < √5
        (3.0, 0.9, 2.0, False, 3.0),  # 9 > 5 + 1.8²
        (3.0, 1.5, 2.0, True, 1.0),  # 3 < √(1 + 4 + 3²): the mean of four rows that scatter by 3, twice
    ],
)
def test_power_or_law_or_neither(distance, scatter, error, chosen, expected):
    follows = np.sqrt(1.0 - 0.25) / 0.07
    top = np.full((4, 1), 100.0)
    rungs = [Rung(level(rows), rows) for rows in (top, top)]
    law = np.array([[1.0], [1.0], [1.0 - follows / 100.0]])
    noise = 2.0 * scatter * np.array([[1.0], [-1.0], [1.0], [-1.0]])
    power = np.array([1.2]), -follows + distance + noise, np.array([error])
    exponent, remainder, stated = the_surer(power, rungs, law)
    assert bool(np.isnan(exponent[0])) is chosen
    assert stated[0] == pytest.approx(expected, rel=1e-9)
    assert remainder.mean() == pytest.approx(-follows + (0.0 if chosen else distance), rel=1e-9)


def test_the_scatter_that_chooses_has_the_freedom_of_the_highest_rung():
    # 13 rows, 4 of which have it: t = 3.18, and 0.9² + (3.18 · 0.13)² < 1 < 0.9² + (3.18 · 0.15)², with t = 2.18 both <
    follows = np.sqrt(1.0 - 0.25) / 0.07
    top = np.full((13, 1), 100.0)
    rungs = [Rung(level(top), top), Rung(level(top[::4], rows=np.arange(0, 13, 4)), top)]
    law = np.array([[1.0], [1.0], [1.0 - follows / 100.0]])
    for scatter, chosen in ((0.13, False), (0.15, True)):
        noise = np.zeros((13, 1))
        noise[:2, 0] = scatter * 13.0 / np.sqrt(2.0) * np.array([1.0, -1.0])  # of the mean: `scatter`
        exponent, *_ = the_surer((np.array([1.2]), -follows + noise, np.array([0.9])), rungs, law)
        assert bool(np.isnan(exponent[0])) is chosen


def test_what_the_top_rung_scatters_by_counts_in_both_ways():
    # the remainder of the power takes back what the rung has by chance; the ratio of the law does not
    follows = np.sqrt(1.0 - 0.25) / 0.07
    noise = 2.0 * np.array([[1.0], [-1.0], [1.0], [-1.0]])
    top = 100.0 + noise
    rungs = [Rung(level(rows), rows) for rows in (top, top)]
    law = np.array([[1.0], [1.0], [1.0 - follows / 100.0]])
    # the error of the power is 2 and that of the law 1, but the limit of the law scatters by 3.18 · 0.88
    exponent, *_ = the_surer((np.array([1.2]), -follows - noise, np.array([2.0])), rungs, law)
    assert np.isfinite(exponent[0])


def test_rows_scatter_as_the_top_rung_does():
    values = observed(fall, fall, count=2, scatter=0.05)
    top = observed(fall, fall, count=2, scatter=0.05).finest
    np.testing.assert_allclose(values.extrapolated, top * fall(END) / fall(16.0), rtol=1e-12)


@pytest.mark.parametrize(("end", "until"), [(800.0, 128.0), (40.0, 40.0)])
def test_the_pixel_is_in_the_doubt_of_the_law_up_to_where_it_was_tested(end, until):
    def pixel(law):
        samples = []
        for q, change in ((4.0, 0.2), (8.0, 0.07), (16.0, 0.0)):  # by half the pixel: the highest one shown counts
            samples.append(level(np.full((13, 2), fall(q)), q_max=q, side=64.0 * q))
            if change:
                samples.append(level(np.full((13, 2), fall(q) - change), q_max=q, side=128.0 * q))
        table = fall(np.array([8.0, 16.0, end]))[:, None] * law
        return observe(NAME, samples, capped=True, end=end, settled=4.0, law=table).pixel

    vanishing = 1.0 / (1.0 - 2.0**-1.4)
    by_law, by_power = 0.07 * 8.0 / until * vanishing, (0.2 - 2.0 * 0.07) * 8.0 / 16.0 * vanishing
    assert pixel(np.ones((3, 2))) == pytest.approx(by_law, rel=1e-9)
    refuted = np.array([[1.0, 1.0], [1.0, 1.0], [1.0, 1.5]])  # at the second speed, far from the power
    assert pixel(refuted) == pytest.approx([by_law, by_power], rel=1e-9)


@pytest.mark.slow  # contacts on 1024² points
def test_the_pixel_and_the_doubt_of_the_law_hold_what_vanishing_pixels_change():
    # C(q) ends at 16 q_y, q_y = q_r = 1: rungs to 8 q_y with four pixels per wave, against all of it with 4, 8, 16 on
    # the same surfaces; at rest <T sigma> is the sum of |sigma_q|²/q
    hardness, length = 0.55165, 4 * 2 * np.pi
    load = 0.1 * hardness

    def solved(depth, pixels, count):
        side = int(4 * depth * pixels)
        grid, values = rs.Grid((side, side), (length, length)), []
        roughness = rs.SelfAffineSpectrum(1.0, 0.8, 0.5, 1.0, depth)
        for index in range(count):
            heights = rs.synthesize(roughness, grid, np.random.default_rng([7, index]))
            solid = rs.Solid(1.0, hardness)
            pressure = rs.solve_contact(heights, grid, solid, nominal_pressure=load, tolerance=1e-4).pressure
            power = np.abs(np.fft.fft2(pressure) / side**2) ** 2
            q = 2 * np.pi * np.fft.fftfreq(side, length / side)
            wavenumber = np.hypot(q[:, None], q[None, :])
            wavenumber[0, 0] = np.inf
            values.append([(power / wavenumber).sum()])
        return np.array(values)

    whole, finer, finest = solved(16.0, 4, 8), solved(16.0, 8, 8), solved(16.0, 16, 4)
    last = (finest - finer[:4]).mean()
    vanishing = finer.mean() + last * 2**1.4 / (2**1.4 - 1)  # an error that falls with the power 1.4 of the pixel
    assert abs(whole.mean() / vanishing - 1) > 0.002

    samples = [level(solved(2.0**k, p, 8), q_max=2.0**k, side=4 * 2.0**k * p) for k in (1, 2) for p in (4, 8)]
    samples.append(level(solved(8.0, 4, 8), q_max=8.0, side=128.0))
    heat = {"nominal_pressure": load, "friction_coefficient": load, "conductivity": 1.0, "diffusivity": 1.0}
    law = []
    for q_max in (4.0, 8.0, 16.0):
        stress = plasticity.stress_spectrum(
            rs.SelfAffineSpectrum(1.0, 0.8, 0.5, 1.0, q_max),
            effective_modulus=1.0,
            nominal_pressure=load,
            penetration_hardness=hardness,
            step=0.1,
        )
        law.append([float(flash.flash_temperature(1e-3, stress_spectrum=stress, **heat))])
    values = observe(NAME, samples, capped=True, end=16.0, settled=4.0, law=np.array(law))
    assert np.isnan(values.exponent[0])  # by the law
    stated = np.hypot(values.bandwidth[0], values.pixel[0])
    assert abs(values.extrapolated.mean() - vanishing) < 0.5 * stated
    assert stated < 0.015 * vanishing


def test_only_t_flash_of_two_rungs_or_more_is_continued_by_the_law_of_the_upper_two(monkeypatch):
    seen = []
    monkeypatch.setattr(ladder, "observe", lambda *_, **names: (seen.append(names), observed(fall, None))[1])
    scene = rs.load_scene("steel-1.2GPa")
    q_yield = 50695.4  # of the map's point with these numbers, rad/m
    cut_offs = tuple(q_yield * depth for depth in (4.0, 8.0, 16.0))
    samples = [level(np.ones((13, len(scene.speeds))), q_max=q) for q in cut_offs]
    values_of(scene, "capped", NAME, samples)
    values_of(scene, "capped", "pressure_variance", samples)
    values_of(scene, "capped", NAME, samples[:1])
    assert [names["settled"] for names in seen] == pytest.approx([4.0 * q_yield] * 3, rel=1e-3)
    assert ["law" in names for names in seen] == [True, False, False]
    np.testing.assert_array_equal(seen[0]["law"], prediction.yielded_fall(scene, cut_offs[1:]))


def test_a_scene_is_continued_by_the_law_over_its_own_spectrum():
    scene = replace(rs.load_scene("steel-1.2GPa"), title="continued by the law")
    cut_offs = (2e5, 4e5)
    law = prediction.yielded_fall(scene, cut_offs)
    heat = {"nominal_pressure": 9e7, "friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": 7.6e-6}
    solid = {"effective_modulus": scene.effective_modulus, "nominal_pressure": 9e7, "penetration_hardness": 1.2e9}
    for row, end in zip(law, (*cut_offs, None), strict=True):
        spectrum = scene.spectrum if end is None else scene.spectrum.truncated(q_max=end)
        stress = plasticity.stress_spectrum(spectrum, **solid, step=0.05)
        np.testing.assert_allclose(
            row[-1], flash.flash_temperature(scene.speeds[-1], stress_spectrum=stress, **heat), rtol=0.02
        )
    assert prediction.yielded_fall(replace(scene, surface=replace(scene.surface, hurst=0.2)), cut_offs) is None


def test_a_run_says_that_it_was_continued_by_the_law():
    scene = rs.load_scene("steel-1.2GPa")
    cut_offs = (2e5, 4e5)
    law = prediction.yielded_fall(scene, cut_offs)
    samples = [level(np.repeat(row[None], 13, axis=0), q_max=q, side=q) for q, row in zip(cut_offs, law, strict=False)]
    values = values_of(scene, "capped", NAME, samples)
    np.testing.assert_allclose(values.extrapolated.mean(axis=0), law[-1], rtol=1e-9)
    numerics = Numerics(tuple(Level("capped", (640, 640), q) for q in cut_offs), (4e-3, 4e-3))
    assert any(
        "by the law for contact that yields" in note for note in notes_of(scene, numerics, "capped", NAME, values)
    )
    mixed = values._replace(exponent=np.where(np.arange(values.exponent.size) == 1, 1.2, np.nan))
    told = "extrapolated as q_c^(−p) with p = 1.20, at other speeds by the law for contact that yields"
    assert told in notes_of(scene, numerics, "capped", NAME, mixed)
    alone = values._replace(exponent=np.full_like(values.exponent, 1.2))
    assert "extrapolated as q_c^(−p) with p = 1.20" in notes_of(scene, numerics, "capped", NAME, alone)
    plain = values_of(scene, "capped", NAME, samples, extrapolated=False)
    np.testing.assert_array_equal(plain.extrapolated, plain.finest)
