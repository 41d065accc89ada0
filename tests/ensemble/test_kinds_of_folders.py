"""Drawn surfaces and pressed maps never share a folder, and damaged members of a map are pressed again."""

import shutil
import warnings
from dataclasses import replace

import numpy as np
import pytest
from press_cases import AT_35, drawn_map, write_scene

import roughsim as rs
from roughsim.cli import main
from roughsim.explore.content import load_fields
from roughsim.outputs.run_report import report_run
from roughsim.results.folder import open_run
from roughsim.store.disk import set_aside

NAME = "flash_temperature"
PLACES = [".", "quarters"]  # of a pressed map
ADVICE = "repeat the command that made the folder"


@pytest.fixture(scope="module")
def pressed(capped_scene, tmp_path_factory):
    """A folder with the scene and, in `pressed`, its map; tests copy it."""
    folder = tmp_path_factory.mktemp("kinds")
    scene = write_scene(folder, drawn_map(), capped_scene)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
        rs.press(scene, folder / "pressed", changes=AT_35)
    return folder


@pytest.fixture
def place(pressed, tmp_path):
    """The same in a folder of its own."""
    shutil.copytree(pressed, tmp_path, dirs_exist_ok=True)
    return tmp_path


def contents(folder):
    """What lies in a folder, but claims, which come and go."""
    paths = (
        path for path in sorted(folder.rglob("*")) if path.is_file() and "claims" not in path.parts
    )
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def flip_byte(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize("part", PLACES)
def test_surfaces_are_not_drawn_into_the_folder_of_a_map(place, part):
    folder = place / "pressed" / part
    scene, before = rs.open_run(folder).scene, contents(place)
    more = replace(scene, ensemble=replace(scene.ensemble, max_realizations=8))
    with pytest.raises(
        rs.RecordError,
        match="holds .* pressed map, not a run of drawn surfaces; name another folder",
    ):
        rs.run(more, folder)
    with pytest.raises(rs.RecordError, match="not a run of drawn surfaces"):
        rs.run(more, folder, numerics=rs.open_run(folder).numerics)
    assert contents(place) == before
    assert rs.press(place / "scene.toml", place / "pressed", changes=AT_35).independent == 4


def test_the_command_run_refuses_a_map_before_it_plans(place, capsys):
    for part in PLACES:
        with pytest.raises(SystemExit) as ended:
            main(
                [
                    "run",
                    str(place / "scene.toml"),
                    "-o",
                    str(place / "pressed" / part),
                    "--set",
                    "sliding.speed=35",
                ]
            )
        assert ended.value.code != 0
        assert "pressed map, not a run of drawn surfaces" in " ".join(
            capsys.readouterr().err.split()
        )


def _lost(quarters, _):
    shutil.rmtree(quarters)


def _emptied(quarters, _):
    shutil.rmtree(quarters)
    quarters.mkdir()


def _without_description(quarters, _):
    (quarters / "run.json").unlink()


def _with_damaged_description(quarters, _):
    (quarters / "run.json").write_text("{")


def _a_file(quarters, _):
    shutil.rmtree(quarters)
    quarters.write_text("notes")


def _of_drawn_surfaces(quarters, quick):
    shutil.rmtree(quarters)
    rs.run(replace(quick, ensemble=replace(quick.ensemble, max_realizations=2, until=())), quarters)


def _of_another_map(quarters, _):
    place = quarters.parents[1]
    np.save(place / "map.npy", -np.load(place / "map.npy"))  # upside down, with the same C(q)
    other = rs.press(place / "scene.toml", place / "other", changes=AT_35)
    np.save(place / "map.npy", -np.load(place / "map.npy"))
    shutil.rmtree(quarters)
    shutil.copytree(other.folder / "quarters", quarters)


STATES = {
    _lost: "quarters is lost",
    _emptied: "quarters is no run",
    _without_description: "quarters is no run",
    _with_damaged_description: "run.json is damaged",
    _a_file: "quarters is a file",
    _of_drawn_surfaces: "holds a run of drawn surfaces, not the quarters of a pressed map",
    _of_another_map: "quarters holds another scene: heights is",
}
BEFORE_ANY_FILE = (_lost, _emptied)  # nothing to move aside


@pytest.mark.filterwarnings("ignore:q_min = :RuntimeWarning")
@pytest.mark.parametrize("spoil", STATES)
def test_other_quarters_are_refused_and_pressed_again(place, quick, spoil, recwarn):
    folder = place / "pressed"
    first = rs.open_run(folder).estimate(NAME)
    spoil(folder / "quarters", quick)
    before = contents(folder / "quarters")
    with pytest.raises(
        rs.RecordError, match=f"{STATES[spoil]}.*; repeat `roughsim press SCENE -o {folder}`"
    ):
        rs.open_run(folder)
    recwarn.clear()
    again = rs.press(place / "scene.toml", folder, changes=AT_35).estimate(NAME)
    np.testing.assert_array_equal(again.total_error, first.total_error)
    moved = folder / "damaged" / "quarters"
    named = [
        str(each.message) for each in recwarn if f"it was moved to {moved}" in str(each.message)
    ]
    assert len(named) == (spoil not in BEFORE_ANY_FILE)
    assert contents(moved) == before  # nothing of it is deleted


def test_folders_are_set_aside_under_free_names(tmp_path):
    for k in range(3):
        (tmp_path / "a").mkdir()
        (tmp_path / "a" / "file").write_text(str(k))
        set_aside(tmp_path / "a", tmp_path / "kept")
    assert {path.name: (path / "file").read_text() for path in (tmp_path / "kept").iterdir()} == {
        "a": "0",
        "a-1": "1",
        "a-2": "2",
    }


def test_a_map_is_not_pressed_into_a_run_of_drawn_surfaces(pressed, tmp_path, quick):
    run = rs.run(
        replace(quick, ensemble=replace(quick.ensemble, max_realizations=2, until=())),
        tmp_path / "run",
    )
    before = contents(run.folder)
    with pytest.raises(
        rs.RecordError, match="holds a run of drawn surfaces, not a pressed map; name another"
    ):
        rs.press(pressed / "scene.toml", run.folder, changes=AT_35)
    assert contents(run.folder) == before
    with pytest.raises(rs.RecordError, match="holds a run; name a new folder for the study"):
        rs.study(quick, vary={"sliding.nominal_pressure": [4e7]}, folder=pressed / "pressed")


def test_a_map_is_not_pressed_into_a_study(pressed, tmp_path):
    (tmp_path / "study" / "points").mkdir(parents=True)
    (tmp_path / "study" / "study.json").write_text("{}")
    with pytest.raises(rs.RecordError, match="holds a study; name a new folder"):
        rs.press(pressed / "scene.toml", tmp_path / "study", changes=AT_35)


@pytest.mark.parametrize("part", PLACES)
def test_a_damaged_member_of_a_map_is_moved_aside_and_pressed_again(place, part):
    folder = place / "pressed"
    first = rs.open_run(folder).estimate(NAME)
    member = folder / part / "realizations" / "L1-000000.h5"
    whole = rs.open_run(folder / part).values(NAME, extrapolated=False).finest.copy()
    flip_byte(member)
    with pytest.raises(rs.RecordError, match=f"L1-000000.h5 is damaged .*{ADVICE}"):
        rs.open_run(folder)
    with pytest.warns(
        RuntimeWarning, match="is damaged .* moved to .*damaged.L1-000000.h5 and is done again"
    ):
        again = rs.press(place / "scene.toml", folder, changes=AT_35)
    assert (folder / part / "damaged" / "L1-000000.h5").exists()
    np.testing.assert_array_equal(
        rs.open_run(folder / part).values(NAME, extrapolated=False).finest, whole
    )
    np.testing.assert_array_equal(again.estimate(NAME).mean, first.mean)
    np.testing.assert_array_equal(again.estimate(NAME).total_error, first.total_error)


@pytest.mark.parametrize("member", ["L0-000001", "L0-000003", "L1-000002"])
@pytest.mark.parametrize("damaged", [True, False])
def test_an_error_by_fewer_quarters_is_not_stated_as_known(place, member, damaged, capsys):
    whole = rs.open_run(place / "pressed")
    assert np.isfinite(whole.estimate(NAME).budget["size"]).all()
    assert not [line for line in whole.warnings if "lost or damaged" in line]
    path = place / "pressed" / "quarters" / "realizations" / f"{member}.h5"
    flip_byte(path) if damaged else path.unlink()
    run = open_run(place / "pressed", damaged="skip")
    assert np.isnan(run.estimate(NAME).budget["size"]).all()
    assert [line for line in run.warnings if "lost or damaged" in line]
    with pytest.raises(SystemExit):
        main(["status", str(place / "pressed")])
    words = " ".join(" ".join(capsys.readouterr()).split())
    assert "± ≥" in words
    assert "size: unknown" in words


def test_advice_on_a_damaged_or_missing_member_fits_a_press(place, capsys):
    quarters = place / "pressed" / "quarters"
    flip_byte(quarters / "realizations" / "L0-000001.h5")
    with pytest.raises(SystemExit):
        main(["status", str(quarters)])
    assert ADVICE in " ".join(" ".join(capsys.readouterr()).split())
    (quarters / "realizations" / "L0-000001.h5").unlink()
    with pytest.raises(SystemExit):
        main(["status", str(quarters)])
    words = " ".join(" ".join(capsys.readouterr()).split())
    assert "lost: L0-000001" in words
    assert ADVICE in words


def test_fields_of_a_map_that_were_not_kept_are_not_drawn(place):
    quarters = rs.open_run(place / "pressed" / "quarters")
    level = len(quarters.numerics.levels) - 1
    lost = next(index for index in range(4) if index not in quarters.kept(level))
    with pytest.raises(
        ValueError, match=r"press the map in a new folder with --set numerics.keep_fields="
    ):
        load_fields(quarters, level, lost)  # drawing it would show another surface


def test_the_page_of_a_map_says_how_to_press_it(place, tmp_path):
    page = report_run(rs.open_run(place / "pressed"), tmp_path / "page.html").read_text()
    assert "roughsim press scene.toml -o pressed" in page
    assert "roughsim run scene.toml" not in page
