"""A number of realizations in place of a target: exactly so many of each lowest level."""

from dataclasses import replace

import pytest
from press_cases import AT_35, drawn_map, write_scene
from some_rows import some
from stored_cases import members_of

import roughsim as rs
from roughsim.cli import main
from roughsim.planning.plan import numerics_of

GOAL = {"flash_temperature": 0.9}  # met by the first round


@pytest.fixture(scope="module")
def scene(capped_scene):
    """A scene whose target is met by the first twelve members, and whose most are six."""
    return replace(
        capped_scene, ensemble=replace(capped_scene.ensemble, until=GOAL, max_realizations=6)
    )


def lowest(run):
    """The members that count, of the lowest level of each column."""
    return [run.counts[run.numerics.coarse_levels(column)[0]] for column in run.numerics.columns]


@pytest.mark.parametrize("number", some([3, 12, 29]))
def test_as_many_members_as_asked_for_are_computed_for_any_target(scene, tmp_path, number):
    run = rs.run(scene, tmp_path / "run", realizations=number)
    assert lowest(run) == [number, number]
    assert min(run.counts) > 0  # each higher level has some
    assert run.finished
    assert (run.until, run.max_realizations, run.target_met) == ({}, number, False)
    assert "target" not in str(rs.status(run)).splitlines()[1]
    again = rs.open_run(run.folder)
    assert (again.counts, again.finished) == (run.counts, True)


def written(folder):
    """The times at which members were computed."""
    return {key: member.provenance["written"] for key, member in members_of(folder).items()}


@pytest.mark.slow
def test_a_larger_number_continues_and_a_smaller_one_leaves_members_out(scene, tmp_path, calls):
    first = rs.run(scene, tmp_path / "run", realizations=4)
    stored = written(first.folder)
    assert lowest(rs.run(scene, tmp_path / "run", realizations=13)) == [13, 13]
    assert stored.items() <= written(first.folder).items()
    assert lowest(rs.run(scene, tmp_path / "run", realizations=4)) == [4, 4]
    target = rs.run(scene, tmp_path / "run")  # of the scene again
    assert target.until == GOAL
    fresh = rs.run(scene, tmp_path / "fresh", realizations=13)
    assert lowest(rs.run(scene, tmp_path / "run", realizations=13)) == [13, 13]
    assert fresh.counts == rs.open_run(tmp_path / "run").counts


@pytest.mark.slow
def test_the_scene_and_the_command_give_the_number_too(scene, tmp_path, capsys):
    text = scene.to_toml().replace("[ensemble]\n", "[ensemble]\nrealizations = 5\n")
    (tmp_path / "scene.toml").write_text(text)
    words = ["run", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "run")]
    for more, number in ([], 5), (["--members", "7"], 7):
        with pytest.raises(SystemExit) as ended:
            main([*words, *more])
        assert ended.value.code == 0
        assert f"{number} realizations in" in capsys.readouterr().err
    for option in (["--max", "9"], ["--until", "flash_temperature=1%"], ["--target-error", "1%"]):
        with pytest.raises(SystemExit) as ended:
            main([*words, *option])
        assert ended.value.code == 1
        assert (
            "does not go with ensemble.realizations = 5, which fixes the number"
            in capsys.readouterr().err
        )


@pytest.mark.slow
def test_each_point_of_a_study_has_the_number(scene, tmp_path):
    fixed = replace(scene, ensemble=replace(scene.ensemble, realizations=3))
    study = rs.study(
        fixed, vary={"sliding.nominal_pressure": [5e7, 9e7]}, folder=tmp_path / "study"
    )
    assert [lowest(run) for _, run in study.results] == [[3, 3], [3, 3]]
    assert study.finished == 2


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:q_min = :RuntimeWarning")
def test_a_map_is_pressed_once_for_any_number(scene, tmp_path):
    path = write_scene(
        tmp_path, drawn_map(), replace(scene, ensemble=replace(scene.ensemble, realizations=3))
    )
    run = rs.press(path, tmp_path / "run", changes=AT_35)
    assert run.realizations == 1
    assert run.counts == (1, 1, 4, 4)


def test_the_plan_states_the_cost_of_the_number(scene):
    seconds = []
    for number in (300, 30000):
        fixed = replace(scene, ensemble=replace(scene.ensemble, realizations=number))
        (cost,) = (reason for reason in numerics_of(fixed).reasons if reason.quantity == "CPU time")
        assert cost.text.startswith(f"of realizations = {number}, ")
        seconds.append(cost.value)
    assert seconds[0] != seconds[1]
