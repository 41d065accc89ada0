"""Contact that yields, continued by a law of it: right where the law is, refuted by the rungs where it is not."""

from dataclasses import replace

import numpy as np
import pytest
from ladder_cases import NAME, level

import roughsim as rs
from roughsim import prediction
from roughsim.estimate.continuation import Rung, the_surer
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
        (3.0, 0.0, 2.0, False, 3.0),  # 3 > √(1 + 4): one of the two is wrong
        (2.0, 0.0, 2.0, True, 1.0),
        (3.0, 1.5, 2.0, True, 1.0),  # 3 < √(1 + 4 + 3²): the mean of four rows that scatter by 3, twice
    ],
)
def test_power_or_law_or_neither(distance, scatter, error, chosen, expected):
    follows = np.sqrt(1.0 - 0.25) / 0.07
    top = np.full((4, 1), 100.0)
    ladder = [Rung(level(rows), rows) for rows in (top, top)]
    law = np.array([[1.0], [1.0], [1.0 - follows / 100.0]])
    noise = 2.0 * scatter * np.array([[1.0], [-1.0], [1.0], [-1.0]])
    power = np.array([1.2]), -follows + distance + noise, np.array([error])
    exponent, remainder, stated = the_surer(power, ladder, law)
    assert bool(np.isnan(exponent[0])) is chosen
    assert stated[0] == pytest.approx(expected, rel=1e-9)
    assert remainder.mean() == pytest.approx(-follows + (0.0 if chosen else distance), rel=1e-9)


def test_rows_scatter_as_the_top_rung_does():
    values = observed(fall, fall, count=2, scatter=0.05)
    top = observed(fall, fall, count=2, scatter=0.05).finest
    np.testing.assert_allclose(values.extrapolated, top * fall(END) / fall(16.0), rtol=1e-12)


def test_the_pixel_is_in_the_doubt_of_the_law_up_to_where_it_was_tested():
    def rungs(law):
        samples = []
        for q in (4.0, 8.0, 16.0):  # half the pixel changes 2 % at 4, 1 % at 8: all of it goes with 1/q_c
            samples.append(level(np.full((13, 1), fall(q)), q_max=q, side=64.0 * q))
            if q < 16.0:
                samples.append(level(np.full((13, 1), fall(q) - 0.56 / q), q_max=q, side=128.0 * q))
        table = fall(np.array([8.0, 16.0, END]))[:, None] if law else None
        return observe(NAME, samples, capped=True, end=END, settled=4.0, law=table)

    assert rungs(law=False).pixel[0] == pytest.approx(0.0, abs=1e-12)
    assert rungs(law=True).pixel[0] == pytest.approx(0.56 / min(END, 64.0) / (1.0 - 2.0**-1.4), rel=1e-9)


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
    plain = values_of(scene, "capped", NAME, samples, extrapolated=False)
    np.testing.assert_array_equal(plain.extrapolated, plain.finest)
