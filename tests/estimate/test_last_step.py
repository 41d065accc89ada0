"""Where nothing continues the cut-offs, what the last step to the highest one has changed is part of the error."""

from dataclasses import replace

import numpy as np
import pytest
from ladder_cases import NAME, level, seldom

import roughsim as rs
from roughsim.comparison.tables import budget_table
from roughsim.ensemble.status import status_dict
from roughsim.estimate.errors import estimate, quotient
from roughsim.estimate.ladder import observe
from roughsim.results.share import times_share
from roughsim.scene import parse_scene

RISING = 14.77, 25.92, 40.21  # K, at three cut-offs that double
NOT_KNOWN = np.full((len(RISING) + 1, 1), np.nan)  # the theory, where it is not known to hold

# roughness that goes on far beyond the cut-offs, and that yields at short waves only: no law continues it
BEYOND = """
[surface]
rms_height = "24 nm"
hurst = 0.0
q_min = 2.3e3
q_max = 1.7e6
[body]
youngs_modulus = "200 GPa"
poisson_ratio = 0.3
penetration_hardness = "2 GPa"
conductivity = 30
density = 7900
heat_capacity = 500
[counterface]
conductivity = 30
density = 7900
heat_capacity = 500
[sliding]
nominal_pressure = "50 MPa"
friction_coefficient = 0.11
speed = [0, 1, 35]
heat_partition = 0.6
[ensemble]
max_realizations = 3
until = {}
[numerics]
lengths = [2.74e-3, 2.74e-3]
tolerance = 1e-4
levels = [
  { column = "smoothed", shape = [64, 64], q_max = 3.6e4 },
  { column = "smoothed", shape = [128, 128], q_max = 7.2e4 },
  { column = "capped", shape = [64, 64], q_max = 3.6e4 },
  { column = "capped", shape = [128, 128], q_max = 7.2e4 },
]
"""


def ladder(values=RISING, n=16, every=1):
    """Levels at doubling cut-offs, 1 % of scatter in all of them alike; finer ones in every k-th realization."""
    scatter = 1.0 + 0.01 * np.random.default_rng(0).standard_normal((n, 1))
    scatter /= scatter.mean()
    first = level(values[0] * scatter, q_max=1.0)
    return [first, *(seldom(v * scatter, every, q_max=2.0**k, side=64.0 * 2**k) for k, v in enumerate(values[1:], 1))]


def kelvin(samples, **names):
    return estimate(NAME, observe(NAME, samples, end=100.0, **names))


@pytest.mark.parametrize("capped", [True, False])
@pytest.mark.parametrize(
    "theory",
    [
        NOT_KNOWN,
        np.array([[1.0], [1.5], [2.0], [9.0]]),  # so much would follow that its shape was never tried
    ],
)
def test_the_last_step_is_part_of_the_error_where_nothing_is_continued(capped, theory):
    found = kelvin(ladder(), capped=capped, theory=theory)
    assert found.mean[0] == pytest.approx(40.21)
    assert found.bias[0] == pytest.approx(0.0, abs=1e-9)
    assert found.budget["last step"][0] == pytest.approx(40.21 - 25.92)
    assert found.total_error[0] >= 40.21 - 25.92
    assert "bandwidth" in found.unknown  # and more may follow
    assert "≥14" in str(found.number(0))


def test_a_fall_counts_as_a_rise():
    found = kelvin(ladder(RISING[::-1]), capped=True, theory=NOT_KNOWN)
    assert found.mean[0] == pytest.approx(14.77)
    assert found.budget["last step"][0] == pytest.approx(25.92 - 14.77)


def test_the_last_step_is_that_of_the_cut_off_and_not_of_the_pixel():
    coarse, middle, top = ladder()
    finer = level(1.1 * top.numbers[NAME], q_max=top.q_max, side=2 * top.side)
    found = kelvin([coarse, middle, top, finer], capped=False, theory=NOT_KNOWN)
    assert found.budget["last step"][0] == pytest.approx(40.21 - 25.92)


def test_one_cut_off_shows_no_step():
    found = kelvin(ladder()[:1], capped=True, theory=np.full((2, 1), np.nan))
    assert "last step" not in found.budget
    assert "bandwidth" in found.unknown
    assert "bandwidth: unknown: no level of the run shows it" in found.explain()


def test_what_is_continued_has_no_last_step():
    by_theory = np.array([[1.0], [1.8], [2.6], [2.7]])
    assert "last step" not in kelvin(ladder(), capped=True, theory=by_theory).budget
    assert "last step" not in kelvin(ladder((10.0, 8.0, 7.0)), capped=True).budget  # as a power
    whole = estimate(NAME, observe(NAME, ladder(), capped=True, end=4.0))  # the levels reach the end of C(q)
    assert "last step" not in whole.budget
    assert "bandwidth" not in whole.unknown


def test_what_has_no_limit_stays_the_value_at_the_cut_off():
    samples = [replace(sample, numbers={"flash_laplacian": sample.numbers[NAME]}) for sample in ladder()]
    found = estimate("flash_laplacian", observe("flash_laplacian", samples, capped=True, end=100.0))
    assert "last step" not in found.budget
    assert found.mean[0] == pytest.approx(40.21)


def test_a_ratio_has_the_last_steps_of_both_columns():
    above = observe(NAME, ladder(), capped=True, end=100.0, theory=NOT_KNOWN)
    below = observe(NAME, ladder((20.0, 19.0, 20.0)), capped=False, end=100.0, theory=NOT_KNOWN)
    found = quotient(above, below)
    expected = 40.21 / 20.0 * np.hypot(14.29 / 40.21, 1.0 / 20.0)
    assert found.budget["last step"][0] == pytest.approx(expected)
    assert found.total_error[0] >= expected
    # an exact value is taken up to the same cut-off: the ratio is one at q_c
    assert "last step" not in quotient(above, np.array([20.0])).budget


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return rs.run(parse_scene(BEYOND), tmp_path_factory.mktemp("beyond") / "run")


def level_means(run, name):
    """Means of all levels over speed, from the numbers of the members."""
    values = [sample.numbers[name].mean(axis=0) for column in run.numerics.columns for sample in run.samples(column)]
    return dict(zip(((c, k) for c in run.numerics.columns for k in range(2)), values, strict=True))


def test_every_output_of_a_run_has_the_last_step(run):
    means = level_means(run, NAME)
    step = 0.6 * np.abs(means["capped", 1] - means["capped", 0])  # with the share of the heat
    assert step[2] > 0.2 * 0.6 * means["capped", 1][2]  # or the scene is none of those that are meant
    found = run.estimate(NAME)
    np.testing.assert_allclose(found.budget["last step"], [0.0, *step[1:]], rtol=1e-9)  # exactly zero at rest
    assert (found.total_error >= found.budget["last step"]).all()
    assert "bandwidth" in found.unknown
    assert found.unknown_at(0) == ()
    again = rs.open_run(run.folder).estimate(NAME)  # from estimates.json
    np.testing.assert_array_equal(again.budget["last step"], found.budget["last step"])
    told = status_dict(run)["estimates"][NAME]
    assert told["total_error"][2] >= step[2]
    cell = next(row for row in rs.compare(run).rows if row.observable == NAME and row.speed == 35.0).columns["capped"]
    assert cell.total_error >= step[2]
    assert "bandwidth" in cell.unknown


def test_other_observables_of_a_run_have_their_own_last_step(run):
    for name in ("contact_fraction", "pressure_variance"):
        means = level_means(run, name)
        found = run.estimate(name)
        if "bandwidth" in found.unknown:
            np.testing.assert_allclose(found.budget["last step"], np.abs(means["capped", 1] - means["capped", 0]))


def test_the_words_say_that_more_may_follow(run):
    said = run.estimate(NAME).explain()
    assert "last step: what the last step to the highest q_c has changed" in said
    assert "bandwidth: unknown: the waves above the highest q_c may change more than the last step to it did" in said
    assert "the value of the highest q_c, and what the last step to it changed is part of the error" in said


def test_the_table_of_errors_has_each_part_in_its_own_column(run):
    table = budget_table(run, "capped")
    titles = [column.title for column in table.columns]
    at = titles.index("last step")
    assert {len(row) for row in table.rows} == {len(titles)}
    found = run.estimate(NAME)
    row = next(row for row in table.rows if row[0].startswith(NAME) and row[1] == "35")
    assert row[at].value == pytest.approx(found.budget["last step"][2])
    assert row[titles.index("pixel")].value == pytest.approx(found.budget["pixel"][2], nan_ok=True)


def test_a_share_of_the_heat_that_was_measured_adds_its_own_last_step():
    kelvins = observe(NAME, ladder(), capped=True, end=100.0, theory=NOT_KNOWN)
    share = observe(NAME, ladder((0.5, 0.6, 0.7)), capped=True, end=100.0, theory=NOT_KNOWN)
    found = times_share(kelvins, share)
    assert found.last_step[0] == pytest.approx(0.7 * (40.21 - 25.92) + 40.21 * 0.1)
    assert times_share(kelvins, np.array([0.5])).last_step[0] == pytest.approx(0.5 * (40.21 - 25.92))
