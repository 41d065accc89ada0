"""The run folder: what a start may take up, and a description of which no value can be changed unseen."""

import errno
import json
import shutil
from dataclasses import replace

import pytest
from some_rows import some
from stored_cases import split_members

import roughsim as rs
from roughsim.errors import RecordError
from roughsim.results import folder as folder_module
from roughsim.results import members
from roughsim.results.description import folder_state, read_description


@pytest.fixture(scope="module")
def finished(capped_scene, tmp_path_factory):
    """A small run; tests work on copies."""
    numerics = replace(
        capped_scene.numerics, levels=({"column": "capped", "shape": [32, 32], "q_max": 4e4},)
    )
    scene = replace(capped_scene, numerics=numerics)
    return rs.run(scene, tmp_path_factory.mktemp("finished") / "run", max_realizations=2)


@pytest.fixture
def folder(finished, tmp_path):
    return shutil.copytree(finished.folder, tmp_path / "run")


# what a start makes before run.json, in its order, and at any moment of it
MADE = (
    [],
    ["claims/"],
    ["members/"],
    ["members/", ".scene.toml.node7-123-0a1b2c3d.tmp"],
    ["members/", "scene.toml"],
    ["members/", "scene.toml", ".run.json.4711.tmp"],
)
OTHERS = (
    ["scene.toml"],
    ["notes.txt"],
    ["members/", "scene.toml", "notes.txt"],
    ["members/", "members/L0-000000.h5"],
    ["members/", "members/mine.dat"],
    ["members"],
)


def made(folder, names):
    folder.mkdir()
    for name in names:
        (folder / name).mkdir() if name.endswith("/") else (folder / name).write_text("")


@pytest.mark.parametrize("names", MADE, ids=str)
def test_a_start_that_was_interrupted_before_it_had_written_run_json_is_taken_up(tmp_path, names):
    made(tmp_path / "run", names)
    assert folder_state(tmp_path / "run") == "free"


@pytest.mark.parametrize("moves", [5, 1000])
def test_a_file_that_moves_whenever_it_is_opened_is_read_when_it_stays(folder, monkeypatch, moves):
    genuine, opened = members.read_part, []

    def read(path, known):
        opened.append(path)
        if len(opened) <= moves:
            raise FileNotFoundError(errno.ENOENT, "No such file", str(path))
        return genuine(path, known)

    monkeypatch.setattr(members, "read_part", read)
    if moves == 5:
        assert rs.open_run(folder).realizations == 2
    else:
        with pytest.raises(FileNotFoundError, match="members.h5"):
            rs.open_run(folder)


@pytest.mark.parametrize("place", ["runs", "runs/new"])
def test_a_link_to_a_folder_that_is_gone_is_named(quick, tmp_path, place):
    # as to a scratch disk that was cleared
    (tmp_path / "runs").symlink_to(tmp_path / "cleared")
    words = r"runs is a link to \S*cleared, which does not exist; make that folder, or name another"
    with pytest.raises(RecordError, match=words):
        rs.run(quick, tmp_path / place)
    with pytest.raises(RecordError, match=words):
        rs.study(quick, vary={"sliding.friction_coefficient": [0.1, 0.2]}, folder=tmp_path / place)
    (tmp_path / "cleared").mkdir()
    assert rs.run(quick, tmp_path / place, max_realizations=2).realizations == 2


def test_a_run_goes_on_from_each_moment_of_its_start(finished, tmp_path):
    for number, names in enumerate((MADE[2], MADE[5])):
        made(tmp_path / f"run{number}", names)
        assert (
            rs.run(finished.scene, tmp_path / f"run{number}", max_realizations=1).realizations == 1
        )
    (tmp_path / "run0" / "scene.toml").unlink()  # it is written after run.json
    assert rs.run(finished.scene, tmp_path / "run0", max_realizations=2).realizations == 2


def test_a_start_leaves_nothing_of_killed_ones_behind(finished, folder):
    left = [f".{name}.node7-123-0a1b2c3d.tmp" for name in ("run.json", "scene.toml")]
    mine = [".notes.txt.node7-123-0a1b2c3d.tmp", ".run.json.swp"]
    made_before = {path.name for path in folder.iterdir()}
    for name in (*left, *mine):
        (folder / name).write_text("{")
    rs.run(finished.scene, folder, max_realizations=2)
    assert {path.name for path in folder.iterdir()} == made_before | set(mine)


def test_an_edited_scene_of_a_run_is_refused_by_the_key(folder):
    text = (folder / "scene.toml").read_text()
    (folder / "scene.toml").write_text(text.replace("hurst = 0.8", "hurst = 0.7"))
    with pytest.raises(
        rs.RecordError, match=r"of different scenes: surface\.hurst differs; undo the edit"
    ):
        rs.open_run(folder)


@pytest.mark.parametrize("names", OTHERS, ids=str)
def test_a_folder_with_something_of_somebody_is_no_start(tmp_path, names):
    made(tmp_path / "run", names)
    assert folder_state(tmp_path / "run") == "foreign"


def test_a_run_a_missing_folder_and_a_file_are_told_apart(folder, tmp_path):
    assert folder_state(folder) == "run"
    assert folder_state(tmp_path / "none") == "free"
    assert folder_state(folder / "run.json") == "foreign"


CHANGES = {
    "numerics": {},
    "reasons": [["a", "b", "c"]],
    "versions": {},
}


@pytest.mark.parametrize("key", CHANGES)
def test_a_changed_value_of_run_json_is_refused_by_name(folder, key):
    path = folder / "run.json"
    description = json.loads(path.read_text())
    path.write_text(json.dumps(description | {key: CHANGES[key]}))
    with pytest.raises(
        rs.RecordError, match=rf"^{key} in .*run.json was changed since the run wrote it"
    ):
        rs.open_run(folder)
    path.write_text(
        json.dumps(description, indent=4, sort_keys=True)
    )  # the same values, written otherwise
    assert rs.open_run(folder).realizations == 2
    del description[key]
    path.write_text(json.dumps(description))
    with pytest.raises(rs.RecordError, match=key):
        rs.open_run(folder)


def test_a_run_json_without_checksums_is_refused(folder):
    path = folder / "run.json"
    description = json.loads(path.read_text())
    del description["checksums"]
    path.write_text(json.dumps(description))
    with pytest.raises(rs.RecordError, match="was changed since the run wrote it"):
        rs.open_run(folder)


def test_a_run_of_an_older_version_is_refused_in_one_sentence(folder):
    path = folder / "run.json"
    description = json.loads(path.read_text())
    path.write_text(
        json.dumps(description | {"format_version": 4, "versions": {"roughsim": "0.1.0"}})
    )
    words = r"run\.json has the older format 4, and this roughsim reads 8; read .* that wrote it \(0\.1\.0\)$"
    for call in (rs.open_run, lambda place: rs.run(rs.load_scene("demo"), place)):
        with pytest.raises(rs.RecordError, match=words):
            call(folder)


def test_an_identity_with_a_key_of_no_value_is_not_that_of_the_scene(folder, finished):
    description = read_description(folder)
    more = replace(description, scene=description.scene | {"surface.of_nothing": None})
    more.write(folder, finished.scene)
    with pytest.raises(
        rs.RecordError, match=r"run\.json and scene\.toml are of different scenes: a key differs"
    ):
        rs.open_run(folder)


@pytest.mark.parametrize(("memory", "opens"), [(2 * 8 * 32**2 - 1, False), (2 * 8 * 32**2, True)])
def test_a_run_whose_field_needs_more_than_half_of_the_memory_is_refused(
    quick, tmp_path, monkeypatch, memory, opens
):
    run = rs.run(quick, tmp_path / "run", max_realizations=1)
    monkeypatch.setattr(folder_module, "exceeds", lambda needed, share: needed > share * memory)
    if opens:
        assert rs.open_run(run.folder).realizations == 1
    else:
        with pytest.raises(
            rs.RecordError, match=r"a field of 1024 points needs 8.19e-06 GB, more than half of"
        ):
            rs.open_run(run.folder)


@pytest.mark.parametrize(("count", "more"), some([(6, " and 1 more"), (5, "")]))
def test_five_missing_members_are_named_and_of_others_the_number(count, more, quick, tmp_path):
    names = [f"L0-00000{index}" for index in range(1, count + 1)]
    run = rs.run(quick, tmp_path / "run", max_realizations=count + 2, until={})
    for name in names:
        (split_members(run.folder) / "members" / f"{name}.h5").unlink()
    (line,) = folder_module.left_out(rs.open_run(run.folder))
    assert line.startswith(f"lost: {', '.join(names[:5])}{more}; only the 1")


@pytest.mark.parametrize("goal", [0.0, 1.0, -0.1])
def test_a_target_that_is_no_share_is_refused(folder, goal):
    lines = (folder / "scene.toml").read_text().splitlines()
    lines = [line for line in lines if not line.startswith("until")]
    place = lines.index("[ensemble]") + 1
    (folder / "scene.toml").write_text(
        "\n".join([*lines[:place], f"until = {{ flash_temperature = {goal} }}", *lines[place:]])
    )
    with pytest.raises(rs.RecordError, match="scene.toml.*until"):
        rs.open_run(folder)
