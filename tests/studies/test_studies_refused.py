"""Studies: what cannot be varied, read, begun or opened is refused in one line, and nothing is written."""

import json
import shutil
from functools import partial

import numpy as np
import pytest
from refused_cases import assert_refused
from study_cases import VARY

import roughsim as rs
from roughsim.store.disk import checksum
from roughsim.studies.folder import study_file
from roughsim.studies.trends import paired_ratio
from roughsim.studies.vary import points_of, read_axes

SPEED, LOAD = "sliding.speed", "sliding.nominal_pressure"
MIXES = r"mixes .* with the plain number .*; write all with a unit, or none\. .* {{ logspace = \[{}\] }}"
VARIED = {
    "must name at least one key": [{}, []],
    "must be a list of values": [{SPEED: []}, {SPEED: "3 m/s"}],
    "must be the name of a key": [{3: [1]}],
    r"has the dimension \[temperature\]; a quantity in Pa": [{LOAD: ["1 K"]}],
    r"vary.\"sliding.nominal_pressure\"\[0\] = -1.0 Pa must be greater than 0": [{LOAD: [-1.0]}],
    "1000000 is there twice": [{LOAD: ["1 MPa", "1000 kPa"]}],
    "sliding.speed is there twice": [{SPEED: [1.0], "sliding.speed ": [2.0]}],
    "must be a list of 2 values": [{"a, b": [1, 2]}],
    "is for one key": [{"a, b": {"logspace": [1, 2, 3]}}],
    "first, last and count": [{SPEED: {"logspace": [1, 2]}}, {SPEED: {"geomspace": [1, 2, 3]}}],
    "must be a number > 0": [{SPEED: {"logspace": [0.0, 2.0, 3]}}],
    "count = .* must be a whole number from 2": [
        {SPEED: {"linspace": [1, 2, count]}} for count in (1, 0, -3, 3.0, "3", True, 10**9)
    ],
    "1.5 must be a valid integer": [{"ensemble.seed": {"linspace": [1, 2, 3]}}],
    "above the limit": [
        {"surface.hurst": {"linspace": [0, 1, 200]}, SPEED: {"linspace": [1, 2, 51]}}
    ],
    MIXES.format('"12 MPa", "360 MPa", 20'): [{LOAD: ["12 MPa", "360 MPa", 20]}],  # no 20 Pa
    MIXES.format('"1 MPa", "100 MPa", 9'): [
        {LOAD: ["12 MPa", "360 MPa", np.float64(20)]},
        {LOAD: {"logspace": ["12 MPa", 360.0, 20]}},
        {LOAD: {"linspace": [12.0, "360 MPa", 20]}},
        {SPEED: [["1 m/s", 3.0], "5 m/s"]},
        {"sliding.friction_coefficient": ["10 %", 0.2]},
        {f"{SPEED}, {LOAD}": [["1 m/s", 1e6], ["2 m/s", "2 MPa"]]},
    ],
}
FILES = {
    "vary is missing": 'scene = "demo"\n',
    "scene is missing": "[vary]\n",
    "scene must be the name": 'scene = 3\n[vary]\n"sliding.speed" = [1.0]\n',
    "scenes is not a key of a study": 'scenes = "demo"\n',
    "title is not a key of a study": 'title = "mine"\n',
    "not valid TOML": "scene = \n",
}
STUDIES = {
    r"nominal_pressure=5e\+09.*exceeds body.penetration_hardness": {"vary": {LOAD: [1e8, 5e9]}},
    "did you mean": {"vary": {"sliding.nominal_presure": [1e8]}},
    "are the same scene: no number of a member depends on their difference": {
        "vary": {"body.melting_temperature": [1500.0, 1800.0]}
    },
    "is not bundled": {"scene": "a" * 5000},
    "target_error = 0": {"target_error": 0.0},
    "target_error = 1.5": {"target_error": 1.5},
    'target_error = "2 m"': {"target_error": "2 m"},
    "target_error = true must be a valid number": {"target_error": True},
}
AXES = {  # forged, with a checksum
    "cannot be the name of a folder": [[{"keys": ["../../x"], "values": [[1]]}]],
    r"is damaged \((?!its checksum)": [
        [{"keys": [f"sliding.a{i}"], "values": [[j] for j in range(100)]} for i in range(8)],
        [{"keys": [SPEED], "values": [[1], [10**400]]}],
        [],
        [{"keys": [SPEED], "values": [[1, 2]]}],
    ],
}


@pytest.mark.parametrize("words", VARIED)
def test_what_cannot_be_varied_is_refused(words):
    for vary in VARIED[words]:
        assert_refused(lambda given=vary: points_of(read_axes(given)), words)


@pytest.mark.parametrize("words", FILES)
def test_a_study_file_is_refused(words, tmp_path):
    (tmp_path / "study.toml").write_text(FILES[words])
    assert_refused(lambda: study_file(tmp_path / "study.toml"), words)


@pytest.mark.parametrize("words", STUDIES)
def test_a_study_is_refused_before_any_work(words, small, tmp_path):
    given = {"scene": small, "vary": VARY, "folder": tmp_path / "study"} | STUDIES[words]
    assert_refused(lambda: rs.study(given.pop("scene"), **given), words)
    assert not (tmp_path / "study").exists()


def test_a_folder_of_something_else_is_refused(small, done, tmp_path):
    other, notes = small.with_("surface.hurst", 0.7), tmp_path / "notes.txt"
    notes.write_text("mine")
    begin = partial(rs.study, small, vary=VARY)
    for words, call in {
        "study of another scene: surface.hurst is": lambda: rs.study(
            other, vary=VARY, folder=done.folder
        ),
        "holds a study with target_error = None, here it is 0.05": lambda: begin(
            folder=done.folder, target_error="5 %"
        ),
        "holds other files": lambda: begin(folder=tmp_path),
        "is a file": lambda: begin(folder=notes),
        r"is no study: it has no study\.json": lambda: rs.open_study(tmp_path),
    }.items():
        assert_refused(call, words)


@pytest.fixture
def described(done, tmp_path):
    """Writes study.json into the folder of a study, and opens it."""
    shutil.copy(done.folder / "scene.toml", tmp_path)

    def open_with(text):
        (tmp_path / "study.json").write_text(text)
        return rs.open_study(tmp_path)

    return open_with


def test_a_damaged_description_is_refused(described, done):
    for text in ("", "{}", "[]", '{"format_version": 9}', '{"format_version": 1e400}'):
        assert_refused(lambda given=text: described(given), "study.json")
    assert_refused(lambda: described('{"format_version": 1, "axes": 3}'), "study.json")
    changed = (
        (done.folder / "study.json")
        .read_text()
        .replace('"target_error": null', '"target_error": 0.5')
    )
    assert_refused(lambda: described(changed), "is damaged .its checksum does not match")


@pytest.mark.parametrize("words", AXES)
def test_a_forged_description_is_refused_at_once(words, described, done):
    content = json.loads((done.folder / "study.json").read_text())
    del content["checksum"]
    for axes in AXES[words]:
        forged = content | {"axes": axes}
        text = json.dumps(forged | {"checksum": checksum(forged)})
        assert_refused(lambda given=text: described(given), words)


def test_outputs_are_refused_by_name(done, tmp_path):
    (_, run), *_ = done.results
    for words, call in {
        "must end in .csv": lambda: done.save(tmp_path / "t.txt"),
        "observable = 'heat' is unknown": lambda: done.chart(tmp_path / "s.svg", "heat"),
        "^observable = 'heat' is unknown": lambda: paired_ratio(run, run, "heat"),
    }.items():
        assert_refused(call, words)
