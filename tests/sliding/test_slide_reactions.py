"""The distribution of the temperature over contacts that slide: the fields themselves, exact limits, and a run."""

import json
from dataclasses import replace
from math import pi
from types import SimpleNamespace

import numpy as np
import pytest
from slide_cases import SLIDING, of_all
from stored_cases import read_member, split_members, write_member

import roughsim as rs
from roughsim import fourier
from roughsim.observables.distribution import BIN_AREAS, LEVELS
from roughsim.observables.temperatures import SlideFromRest, temperature_distribution
from roughsim.planning.realization import slide_problem
from roughsim.results.snapshots import read_snapshots
from roughsim.scene import parse_scene
from roughsim.sliding.distribution import POSITIONS, Sampler, positions
from roughsim.sliding.member import faces, solve_slide

pytestmark = pytest.mark.usefixtures("few_fields")
SLIDE = 1  # its level
BINNED = "temperature", "pressure"
ASKS = (
    'history = "sliding"\nslid_distance = "1 mm"\nbackground_temperature = "600 K"\n',
    '[reaction]\nactivation_energy = ["0 eV", "1 eV"]\nprefactor = "1e13 1/s"\n[observables]\nheat_above = "700 K"\n',
)
NAMES = [f"temperature_quantile_{of}{name}" for of in ("", "area_") for name in LEVELS]


def asking(history=ASKS[0]):
    text = SLIDING.replace("heat_partition = 0.9\n", f"heat_partition = 0.9\n{history}").replace(
        "[numerics]\n", "[numerics]\nkeep_fields = 1\n"
    )
    return parse_scene(f"{text}\n{ASKS[1]}")


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    return rs.run(asking(), tmp_path_factory.mktemp("asked") / "run")


def by_sorting(temperature, weight, level):
    """Quantile of points by their sorted weights."""
    order = np.argsort(temperature)
    place = np.cumsum(weight[order]) - 0.5 * weight[order]
    return np.interp(level * weight.sum(), place, temperature[order])


def test_the_last_positions_are_equally_spaced_over_the_last_half():
    assert sorted(positions(16, 0.5)) == [9, 10, 11, 12, 13, 14, 15, 16]
    assert sorted(positions(142, 0.5)) == [72, 82, 92, 102, 112, 122, 132, 142]
    assert sorted(positions(4, 0.5)) == [3, 4]


def test_a_wave_of_pressure_and_temperature_has_closed_quantiles():
    # σ = 1 + a cos x and T = B + A cos x: by area T is below B + A cos θ where θ < x, and the heat there is
    # (π − θ − a sin θ)/π
    x = (np.arange(4096) + 0.5) / 4096 * 2 * pi
    pressure = np.broadcast_to((1.0 + 0.6 * np.cos(x))[:, None], (4096, 2))
    sampler = Sampler(rs.Grid((4096, 2), (1.0, 1.0)), [2], 0.5)
    for amplitude in (50.0, 999.0, 150.0):  # steps 1 to 3, of which the second is the last position
        spectrum = fourier.forward(
            np.ascontiguousarray(40.0 + amplitude * np.cos(x)[:, None] * np.ones(2))
        )
        step = SimpleNamespace(contact=SimpleNamespace(pressure=pressure), temperatures=[spectrum])
        sampler.add({50.0: 1, 999.0: 2, 150.0: 3}[amplitude], step)
    theta = np.linspace(0.0, pi, 200_001)
    heat = (pi - theta - 0.6 * np.sin(theta)) / pi
    found = sampler.together(np.array([90.0]))  # ⟨Tσ⟩ = A a/2: scaled to 90 K, A is 300 K
    expected = 300.0 * np.cos(np.interp(list(LEVELS.values()), heat[::-1], theta[::-1]))
    assert found.by_heat[0] == pytest.approx(expected, abs=0.3)
    assert found.by_area[0] == pytest.approx(
        -300.0 * np.cos(pi * np.array([*LEVELS.values()])), abs=0.3
    )


def test_a_member_has_the_quantiles_of_the_fields_of_its_snapshots(asked):
    # 16 steps: all are in the snapshots, and all of the last half are among the positions
    snapshots, numbers = read_snapshots(asked, 0).maps, asked.members[SLIDE, 0].numbers
    pressure = snapshots.pressure[8:]
    touching = pressure > 0.0
    for k in (0, 1):
        temperature, heat = snapshots.temperature[k, 8:][touching], pressure[touching].astype(float)
        # T_flash over all positions is that of the member: no factor is needed
        assert temperature @ heat / heat.sum() == pytest.approx(
            numbers["sliding_flash_temperature"][k], rel=1e-5
        )
        for name, level in LEVELS.items():
            by_heat, by_area = (
                by_sorting(temperature, weight, level) for weight in (heat, np.ones_like(heat))
            )
            assert numbers[f"sliding_temperature_quantile_{name}"][k] == pytest.approx(
                by_heat, rel=1e-4, abs=1e-3
            )
            assert numbers[f"sliding_temperature_quantile_area_{name}"][k] == pytest.approx(
                by_area, rel=1e-4, abs=1e-3
            )


def one_rough_face(speeds, distance, resting, points=64):
    """A smooth body that slides over a rough one: the contact stays as it is."""
    problem = slide_problem(asking(), rs.plan(asking()))
    grid = rs.Grid((points, points), problem.grid.lengths)
    source = rs.HeatSource(list(speeds), 0.11, 30.0, 30.0 / (7900 * 500))
    resting = (resting,) * len(speeds)
    distances = (distance,) * len(speeds)
    return replace(
        problem,
        moving_spectrum=None,
        grid=grid,
        sliding=source,
        resting=resting,
        distances=distances,
        tolerance=1e-4,
    )


def frozen_of(problem):
    heights, _ = faces(problem)
    contact = rs.solve_contact(
        heights,
        problem.grid,
        problem.solid,
        nominal_pressure=problem.nominal_pressure,
        tolerance=1e-4,
    )
    flash = rs.measure(contact, problem.grid, problem.sliding).flash_temperature
    return flash, temperature_distribution(
        contact.pressure, problem.grid, problem.sliding, flash, SlideFromRest()
    )


def test_a_smooth_body_that_takes_all_heat_feels_the_frozen_contact():
    # both slide from rest, the field over half the chord of the cell and the slide over 8 mm: at 35 m/s hot
    # places of the contact hardly differ; along the oblique path T_flash and its distribution differ by their direction
    problem = one_rough_face((35.0,), 8e-3, rs.Body(1e-9, 7.6e-6))
    slid = solve_slide(problem)
    flash, frozen = frozen_of(problem)
    share = slid.numbers["sliding_share"]
    assert share == pytest.approx([1.0], abs=1e-3)
    own = slid.numbers["sliding_flash_temperature"]
    assert own == pytest.approx(flash, rel=0.1)
    for name, place in (("50", 2), ("75", 3), ("90", 4), ("99", 5)):
        ratio = slid.numbers[f"sliding_temperature_quantile_{name}"] / own
        assert ratio == pytest.approx(frozen.by_heat[:, place] / flash, rel=0.06)


def test_twins_that_slide_slowly_have_half_the_temperatures_of_a_resting_contact():
    # at a Péclet number of 3e-4 heat spreads evenly around each spot, and twins share it everywhere
    body = rs.Body(30.0, 30 / (7900 * 500))
    problem = one_rough_face((1e-5,), 1e-3, body)
    slid = solve_slide(problem)
    flash, frozen = frozen_of(problem)
    assert slid.numbers["sliding_share"] == pytest.approx([0.5], abs=1e-3)
    for place, name in enumerate(LEVELS):
        assert slid.numbers[f"sliding_temperature_quantile_{name}"] == pytest.approx(
            0.5 * frozen.by_heat[:, place], rel=5e-3, abs=5e-3 * flash[0]
        )
    heat = BIN_AREAS * slid.moments[0].bins.pressure
    assert (heat * slid.moments[0].bins.temperature).sum() / heat.sum() == pytest.approx(
        0.5 * flash[0], rel=0.01
    )


def test_the_column_sliding_has_quantiles_about_its_own_flash_temperature(asked):
    flash = asked.estimate("flash_temperature", "sliding")
    numbers = [asked.members[SLIDE, i].numbers for i in (0, 1)]
    slid = np.mean([one["sliding_flash_temperature"] for one in numbers], axis=0)
    bins = [read_member(asked.folder, SLIDE, i).moments[0].bins for i in (0, 1)]
    for name in NAMES:
        found, level = asked.estimate(name, "sliding"), LEVELS[name.rpartition("_")[2]]
        own = np.array([one[f"sliding_{name}"] for one in numbers])
        hot = []
        for k in (0, 1):
            both = (np.array([getattr(one, of)[k] for one in bins]) for of in BINNED)
            hot.append(of_all(*both, own[:, k], level, by_area="area" in name))
        # one level, and so nothing beyond it to continue
        assert found.mean == pytest.approx(flash.mean * hot / slid, rel=1e-5)
        apart = np.abs(own - own.mean(axis=0)).max(axis=0)
        assert (np.abs(hot - own.mean(axis=0)) < 1.5 * apart).all()
        assert (found.budget["slide"] > 0.03 * np.abs(flash.mean) * 0.99).all()
    assert {*asked.estimates("sliding")} == {
        "flash_temperature",
        "heat_partition",
        "contact_fraction",
        *NAMES,
    }


def found(run, name, **about):
    return run.reactions("sliding")[name].sel(**about)


def test_reactions_of_the_column_sliding(asked):
    area, flash = (
        asked.estimate("contact_fraction").mean[0],
        asked.estimate("flash_temperature", "sliding"),
    )
    assert found(asked, "reaction_rate", energy=0.0).mean == pytest.approx(1e13 * area)
    rate, warm = (
        found(asked, "reaction_rate", energy=1.0),
        found(asked, "activation_temperature", energy=1.0),
    )
    bins = [read_member(asked.folder, SLIDE, i).moments[0].bins for i in (0, 1)]
    slid = np.mean(
        [asked.members[SLIDE, i].numbers["sliding_flash_temperature"] for i in (0, 1)], axis=0
    )
    mean = np.zeros(2)
    areas = np.array([1.0 / (one.pressure @ BIN_AREAS) for one in bins])  # under the same load
    for one, weight in zip(bins, areas / areas.sum(axis=0), strict=True):
        kelvin = 600.0 + one.temperature * (flash.mean / slid)[:, None]
        mean += weight * (np.exp(-1.602176634e-19 / (1.380649e-23 * kelvin)) @ BIN_AREAS)
    assert rate.mean == pytest.approx(1e13 * area * mean, rel=1e-6)
    assert warm.mean == pytest.approx(-1.602176634e-19 / (1.380649e-23 * np.log(mean)), rel=1e-9)
    by_area = np.average([one.temperature @ BIN_AREAS for one in bins], axis=0, weights=areas)
    assert (warm.mean > 600.0 + by_area * flash.mean / slid).all()  # Jensen
    share = found(asked, "heat_share_above", temperature=700.0)
    assert share.mean[0] == 0.0
    assert 0.5 < share.mean[1] < 1.0


@pytest.mark.slow
def test_compare_and_exports_have_them_in_the_column_sliding(asked):
    comparison = rs.compare(asked)
    rows = json.loads(json.dumps(comparison.to_dict()))["rows"]
    cells = {(row["observable"], row.get("energy"), row["speed"]): row["sliding"] for row in rows}
    for name in NAMES:
        assert cells[name, None, 35.0]["mean"] == asked.estimate(name, "sliding").mean[1]
    assert (
        cells["reaction_rate", 1.0, 35.0]["mean"]
        == found(asked, "reaction_rate", energy=1.0).mean[1]
    )
    sliding = comparison.results.sel(column="sliding")
    assert sliding["activation_temperature"].sel(energy=1.0).mean == pytest.approx(
        found(asked, "activation_temperature", energy=1.0).mean
    )
    assert sliding["temperature_quantile_99"].mean == pytest.approx(
        asked.estimate(NAMES[5], "sliding").mean
    )


@pytest.mark.slow
def test_the_picture_of_reactions_is_also_of_the_column_sliding(asked, tmp_path):
    def drawn(column):
        numbers = tmp_path / f"{column}.csv"
        picture = rs.plot(asked, "reaction", tmp_path / f"{column}.svg", column=column, csv=numbers)
        return picture.read_text(), numbers.read_text()

    picture, numbers = drawn("sliding")
    assert "sliding contact, total errors" in picture
    assert "calibrated" not in picture
    rate = found(asked, "reaction_rate", energy=1.0)
    assert all(f"{value:.7g}" in numbers for value in rate.mean)
    assert "calibrated theory" in drawn("capped")[0]
    with pytest.raises(ValueError, match="column = 'sliding' is not in this run"):
        rs.plot(asked, "pressure", tmp_path / "p.svg", column="sliding")


def test_with_a_duration_the_contact_reacts_above_the_background_of_the_slide(tmp_path):
    history = f'history = "sliding"\nduration = {1e-3 / 35}\nbackground_temperature = "600 K"\n'
    scene = asking(history).with_("sliding.speed", [14.0, 35.0])
    run = rs.run(scene, tmp_path / "run", max_realizations=1)
    numbers, flash = (
        run.members[SLIDE, 0].numbers,
        run.estimate("flash_temperature", "sliding").mean,
    )
    bins = read_member(run.folder, SLIDE, 0).moments[0].bins
    scaled = bins.temperature * (flash / numbers["sliding_flash_temperature"])[:, None]
    kelvin = 600.0 + numbers["sliding_background"][:, None] + scaled
    mean = np.exp(-1.602176634e-19 / (1.380649e-23 * kelvin)) @ BIN_AREAS
    expected = -1.602176634e-19 / (1.380649e-23 * np.log(mean))
    assert found(run, "activation_temperature", energy=1.0).mean == pytest.approx(
        expected, rel=1e-9
    )
    assert np.min(numbers["sliding_background"]) > 20.0


def test_a_scene_that_does_not_ask_stores_nothing_of_it(asked, sliding_run):
    quiet, loud = (run.members[SLIDE, 0].numbers for run in (sliding_run, asked))
    assert {*loud} == {*quiet} | {f"sliding_{name}" for name in NAMES}
    np.testing.assert_array_equal(
        quiet["sliding_flash_temperature"], loud["sliding_flash_temperature"]
    )
    assert sliding_run.members[SLIDE, 0].moments[0].bins is None
    assert not sliding_run.simulated("sliding").reacts


@pytest.mark.slow
def test_slides_of_an_older_version_have_no_reactions(asked, tmp_path):
    folder = tmp_path / "run"
    rs.run(asking(), folder)
    split_members(folder)
    for index in (0, 1):
        member = read_member(folder, SLIDE, index)
        numbers = {
            name: values for name, values in member.numbers.items() if "quantile" not in name
        }
        write_member(
            folder,
            replace(member, moments=(member.moments[0]._replace(numbers=numbers, bins=None),)),
        )
    run = rs.open_run(folder)
    assert run.simulated("capped").reacts
    assert not run.simulated("sliding").reacts
    rows = rs.compare(run).to_dict()["rows"]
    assert {row["sliding"]["mean"] for row in rows if "quantile" in row["observable"]} == {None}
    assert {row["sliding"]["mean"] for row in rows if "energy" in row} == {None}
    with pytest.raises(ValueError, match="have not stored the distribution"):
        run.reactions("sliding")


def test_more_than_eight_positions_are_never_kept():
    assert all(len(positions(end, 0.5)) == min(POSITIONS, end - end // 2) for end in range(4, 200))
