"""The files of a study: what a study file may say, and folders that are damaged, foreign or half begun."""

import json
import shutil

import pytest
from study_cases import VARY

import roughsim as rs
from roughsim.errors import RecordError
from roughsim.scene import SceneError
from roughsim.store.disk import checksum
from roughsim.studies.folder import read, study_file, write


def test_the_folder_of_another_scene_or_of_something_else_is_refused(small, done, tmp_path):
    with pytest.raises(RecordError, match="study of another scene: surface.hurst is"):
        rs.study(small.with_("surface.hurst", 0.7), vary=VARY, folder=done.folder)
    with pytest.raises(
        RecordError, match="holds a study with target_error = None, here it is 0.05"
    ):
        rs.study(small, vary=VARY, folder=done.folder, target_error="5 %")
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(RecordError, match="holds other files"):
        rs.study(small, vary=VARY, folder=tmp_path)
    with pytest.raises(RecordError, match="is a file"):
        rs.study(small, vary=VARY, folder=tmp_path / "notes.txt")
    with pytest.raises(RecordError, match=r"is no study: it has no study\.json"):
        rs.open_study(tmp_path)


def test_a_study_file_names_a_scene_beside_it(tmp_path, small):
    (tmp_path / "my.toml").write_text(small.to_toml())
    (tmp_path / "study.toml").write_text(
        'scene = "my.toml"\n[vary]\n"sliding.nominal_pressure" = ["1 MPa"]\n'
    )
    content = study_file(tmp_path / "study.toml")
    assert content["scene"] == tmp_path / "my.toml"
    (tmp_path / "study.toml").write_text(
        'scene = "demo"\ntarget_error = "2 %"\n[vary]\n"sliding.speed" = [1.0]\n'
    )
    assert study_file(tmp_path / "study.toml")["scene"] == "demo"


def test_the_keys_of_a_study_file_need_no_quotes(tmp_path):
    text = 'scene = "demo"\n[vary]\nsliding.speed = [1.0]\nbody.density = { linspace = [1, 2, 3] }\n"title" = ["a"]\n'
    (tmp_path / "study.toml").write_text(text)
    vary = study_file(tmp_path / "study.toml")["vary"]
    assert vary == {"sliding.speed": [1.0], "body.density": {"linspace": [1, 2, 3]}, "title": ["a"]}


def test_a_scene_whose_name_no_file_can_have_is_refused_as_any_other(tmp_path):
    (tmp_path / "study.toml").write_text(
        f'scene = "{"a" * 5000}"\n[vary]\n"sliding.speed" = [1.0]\n'
    )
    content = study_file(tmp_path / "study.toml")
    with pytest.raises(SceneError, match="is not bundled"):
        rs.study(content["scene"], vary=content["vary"], folder=tmp_path / "study")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('scene = "demo"\n', "vary is missing"),
        ("[vary]\n", "scene is missing"),
        ('scene = 3\n[vary]\n"sliding.speed" = [1.0]\n', "scene must be the name"),
        ('scenes = "demo"\n', "scenes is not a key of a study"),
        ('title = "mine"\n', "title is not a key of a study"),
        ("scene = \n", "not valid TOML"),
    ],
)
def test_a_study_file_that_cannot_be_used_is_refused_in_one_line(tmp_path, text, message):
    (tmp_path / "study.toml").write_text(text)
    with pytest.raises(SceneError, match=message) as refused:
        study_file(tmp_path / "study.toml")
    assert "\n" not in str(refused.value)


def sealed(content):
    """A description as a forger writes it, with the checksum of its content."""
    content = {key: value for key, value in content.items() if key != "checksum"}
    return json.dumps(content | {"checksum": checksum(content)})


@pytest.mark.parametrize(
    "content",
    [
        "",
        "{}",
        "[]",
        '{"format_version": 9}',
        '{"format_version": 1e400}',
        '{"format_version": 1, "axes": 3}',
    ],
)
def test_a_damaged_description_is_refused(done, tmp_path, content):
    shutil.copy(done.folder / "scene.toml", tmp_path)
    (tmp_path / "study.json").write_text(content)
    with pytest.raises(RecordError, match="study.json"):
        rs.open_study(tmp_path)


def test_a_foreign_description_leads_to_no_other_folder(done, tmp_path):
    shutil.copy(done.folder / "scene.toml", tmp_path)
    content = json.loads((done.folder / "study.json").read_text())
    content["axes"][0] = {"keys": ["../../x"], "values": [[1]]}
    (tmp_path / "study.json").write_text(sealed(content))
    with pytest.raises(RecordError, match="cannot be the name of a folder"):
        rs.open_study(tmp_path)


def test_a_foreign_description_of_too_many_points_or_impossible_numbers_is_refused_at_once(
    done, tmp_path
):
    shutil.copy(done.folder / "scene.toml", tmp_path)
    content = json.loads((done.folder / "study.json").read_text())
    many = [{"keys": [f"sliding.a{i}"], "values": [[j] for j in range(100)]} for i in range(8)]
    huge = [{"keys": ["sliding.speed"], "values": [[1], [10**400]]}]
    for axes in (many, huge, [], [{"keys": ["sliding.speed"], "values": [[1, 2]]}]):
        (tmp_path / "study.json").write_text(sealed(content | {"axes": axes}))
        with pytest.raises(RecordError, match=r"is damaged \((?!its checksum)"):
            rs.open_study(tmp_path)


def test_a_description_with_a_changed_value_is_damaged(done, tmp_path):
    text = (done.folder / "study.json").read_text()
    (tmp_path / "study.json").write_text(
        text.replace('"target_error": null', '"target_error": 0.5')
    )
    with pytest.raises(RecordError, match="is damaged .its checksum does not match"):
        rs.open_study(tmp_path)


def test_a_study_killed_before_its_description_was_written_begins_again(done, tmp_path):
    (tmp_path / "points").mkdir()
    description = read(done.folder)
    write(tmp_path, description)
    assert read(tmp_path) == description
    (tmp_path / "study.json").unlink()
    (tmp_path / "points" / "mine").mkdir()
    with pytest.raises(RecordError, match="holds other files"):
        write(tmp_path, description)
