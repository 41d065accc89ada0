"""The files of a study: what a study file may say, and folders that are damaged, foreign or half begun."""

import pytest

from roughsim.errors import RecordError
from roughsim.studies.folder import read, study_file, write


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


def test_a_study_killed_before_its_description_was_written_begins_again(done, tmp_path):
    (tmp_path / "points").mkdir()
    description = read(done.folder)
    write(tmp_path, description)
    assert read(tmp_path) == description
    (tmp_path / "study.json").unlink()
    (tmp_path / "points" / "mine").mkdir()
    with pytest.raises(RecordError, match="holds other files"):
        write(tmp_path, description)
