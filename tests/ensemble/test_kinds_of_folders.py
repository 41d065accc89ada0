"""Drawn surfaces and pressed maps never share a folder, and damaged members of a map are pressed again."""

import json
import shutil
import warnings
from dataclasses import replace

import numpy as np
import pytest
from press_cases import AT_35, drawn_map, write_scene
from some_rows import some
from stored_cases import split_members

import roughsim as rs
from roughsim.cli import main
from roughsim.explore.content import load_fields
from roughsim.results.folder import open_run
from roughsim.store.disk import checksum, set_aside

NAME = "flash_temperature"
LAST = ["L1-000000", "L3-000002"]  # members of the map and of its quadrants
ADVICE = "repeat the command that made the folder"


@pytest.fixture(scope="module")
def pressed(capped_scene, tmp_path_factory):
    """A folder with the scene and, in `pressed`, its map; tests copy it."""
    folder = tmp_path_factory.mktemp("kinds")
    scene = write_scene(folder, drawn_map(), capped_scene)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
        rs.press(scene, folder / "pressed", changes=AT_35)
    split_members(folder / "pressed")
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


def test_surfaces_are_not_drawn_into_the_folder_of_a_map(place):
    folder = place / "pressed"
    scene, before = rs.open_run(folder).scene, contents(place)
    more = replace(scene, ensemble=replace(scene.ensemble, max_realizations=8))
    with pytest.raises(
        rs.RecordError,
        match="holds .* pressed map, not a run of drawn surfaces; name another folder",
    ):
        rs.run(more, folder)
    with pytest.raises(rs.RecordError, match="not a run of drawn surfaces"):
        rs.run(more, folder)
    with pytest.raises(ValueError, match="is of a pressed map, whose levels follow from it"):
        rs.run(more, folder, numerics=rs.open_run(folder).numerics)
    assert contents(place) == before


def test_the_command_run_refuses_a_map_before_it_plans(place, capsys):
    words = ["run", str(place / "scene.toml"), "-o", str(place / "pressed")]
    with pytest.raises(SystemExit) as ended:
        main([*words, "--set", "sliding.speed=35"])
    assert ended.value.code != 0
    told = " ".join(capsys.readouterr().err.split())
    assert "pressed map, not a run of drawn surfaces" in told


@pytest.mark.parametrize("kind", ["map", "quarters"])
def test_a_map_of_the_older_format_is_refused_with_the_sentence_to_press_it_again(place, kind):
    folder = place / "pressed"
    content = json.loads((folder / "run.json").read_text())
    values = {name: value for name, value in content.items() if name != "checksums"}
    values |= {"format_version": 6, "kind": kind}
    values["checksums"] = {name: checksum(value) for name, value in values.items()}
    (folder / "run.json").write_text(json.dumps(values))
    before = contents(folder)
    for call in (rs.open_run, lambda it: rs.press(place / "scene.toml", it, changes=AT_35)):
        with pytest.raises(rs.RecordError, match="older format 6; press the map again, into a new"):
            call(folder)
    assert contents(folder) == before


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:q_min = :RuntimeWarning")
def test_lost_quadrants_are_pressed_again(place):
    folder = place / "pressed"
    first = rs.open_run(folder).estimate(NAME)
    for level in (2, 3):
        for path in (folder / "members").glob(f"L{level}-*"):
            path.unlink()
    assert not rs.open_run(folder).finished
    again = rs.press(place / "scene.toml", folder, changes=AT_35).estimate(NAME)
    np.testing.assert_array_equal(again.total_error, first.total_error)


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


@pytest.mark.parametrize("name", some(LAST))
def test_a_damaged_member_of_a_map_is_moved_aside_and_pressed_again(place, name):
    folder = place / "pressed"
    first = rs.open_run(folder).estimate(NAME)
    member = folder / "members" / f"{name}.h5"
    column = "capped" if name == LAST[0] else "quadrants"
    whole = rs.open_run(folder).values(NAME, column, extrapolated=False).finest.copy()
    flip_byte(member)
    with pytest.raises(rs.RecordError, match=f"{name}.h5 is damaged .*{ADVICE}"):
        rs.open_run(folder)
    with pytest.warns(
        RuntimeWarning, match=f"is damaged .* moved to .*damaged.{name}.h5 and is done again"
    ):
        again = rs.press(place / "scene.toml", folder, changes=AT_35)
    assert (folder / "damaged" / f"{name}.h5").exists()
    np.testing.assert_array_equal(
        rs.open_run(folder).values(NAME, column, extrapolated=False).finest, whole
    )
    np.testing.assert_array_equal(again.estimate(NAME).mean, first.mean)
    np.testing.assert_array_equal(again.estimate(NAME).total_error, first.total_error)


@pytest.mark.parametrize("member", some(["L2-000001", "L2-000003", "L3-000002"]))
@pytest.mark.parametrize("damaged", [True, False])
def test_an_error_by_fewer_quadrants_is_not_stated_as_known(place, member, damaged, capsys):
    whole = rs.open_run(place / "pressed")
    assert np.isfinite(whole.estimate(NAME).budget["size"]).all()
    assert not [line for line in whole.warnings if "lost or damaged" in line]
    path = place / "pressed" / "members" / f"{member}.h5"
    flip_byte(path) if damaged else path.unlink()
    run = open_run(place / "pressed", damaged="skip")
    assert np.isnan(run.estimate(NAME).budget["size"]).all()
    assert [line for line in run.warnings if "lost or damaged" in line]
    with pytest.raises(SystemExit):
        main(["status", str(place / "pressed")])
    words = " ".join(" ".join(capsys.readouterr()).split())
    assert "± ≥" in words
    assert "≥ if one of them is unknown" in words


def test_advice_on_a_damaged_or_missing_member_fits_a_press(place, capsys):
    folder = place / "pressed"
    flip_byte(folder / "members" / "L2-000001.h5")
    with pytest.raises(SystemExit):
        main(["status", str(folder)])
    assert ADVICE in " ".join(" ".join(capsys.readouterr()).split())
    (folder / "members" / "L2-000001.h5").unlink()
    with pytest.raises(SystemExit):
        main(["status", str(folder)])
    words = " ".join(" ".join(capsys.readouterr()).split())
    assert "lost: L2-000001" in words
    assert ADVICE in words


def test_fields_of_a_map_that_were_not_kept_are_not_drawn(place):
    run = rs.open_run(place / "pressed")
    level = len(run.numerics.levels) - 1
    lost = next(index for index in range(4) if index not in run.kept(level))
    with pytest.raises(
        ValueError, match=r"press the map in a new folder with --set numerics.keep_fields="
    ):
        load_fields(run, level, lost)  # drawing it would show another surface


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_the_page_of_a_map_says_how_to_press_it(place, tmp_path):
    page = rs.report(rs.open_run(place / "pressed"), tmp_path / "page.html").read_text()
    assert "roughsim press scene.toml -o pressed" in page
    assert "roughsim run scene.toml" not in page
