"""Run folders from elsewhere: what leads out of them, runs code or fills the memory is refused by name, unread."""

import json
import os
import pickle
import shutil
from dataclasses import replace

import h5py
import numpy as np
import pytest
from damage_cases import forged
from stored_cases import member_path, read_file, split_members

import roughsim as rs
from roughsim.cli import main
from roughsim.results.export import export_run
from roughsim.store import claims
from roughsim.store.disk import checksum
from roughsim.store.member_files import fields_path, read_fields


@pytest.fixture(scope="module")
def whole(capped_scene, tmp_path_factory):
    """A small sound run with fields; tests work on copies."""
    numerics = replace(
        capped_scene.numerics,
        levels=({"column": "capped", "shape": [32, 32], "q_max": 4e4},),
        keep_fields=1,
    )
    return rs.run(
        replace(capped_scene, numerics=numerics),
        tmp_path_factory.mktemp("whole") / "run",
        max_realizations=2,
    )


@pytest.fixture
def folder(whole, tmp_path):
    return split_members(shutil.copytree(whole.folder, tmp_path / "run"))


def external_link(file, secret):
    del file["pressure"]
    file["pressure"] = h5py.ExternalLink(str(secret), "/pressure")


def soft_link(file, secret):
    del file["pressure"]
    file["pressure"] = h5py.SoftLink("/heights")


def external_dataset(file, secret):
    del file["pressure"]
    raw = [(str(secret.with_suffix(".raw")), 0, h5py.h5f.UNLIMITED)]
    file.create_dataset("pressure", (32, 32), "<f4", external=raw)


def virtual_dataset(file, secret):
    del file["pressure"]
    layout = h5py.VirtualLayout((32, 32), "<f4")
    layout[:] = h5py.VirtualSource(str(secret), "pressure", (32, 32))
    file.create_virtual_dataset("pressure", layout)


def objects(file, secret):
    del file["pressure"]
    file.create_dataset("pressure", data=[["a", "b"]], dtype=h5py.string_dtype(), chunks=(1, 2))


def references(file, secret):
    del file["pressure"]
    file.create_dataset(
        "pressure", data=np.array([[file.ref]], h5py.ref_dtype), dtype=h5py.ref_dtype, chunks=(1, 1)
    )


def opaque_pickle(file, secret):
    del file["pressure"]
    file["pressure"] = np.void(pickle.dumps({"a": 1}))


def group(file, secret):
    del file["pressure"]
    file.create_group("pressure")


def beyond_memory(file, secret):
    del file["pressure"]
    file.create_dataset("pressure", (10**7, 10**7), "<f4", chunks=(64, 64), compression="gzip")


ELSEWHERE = r"L0-000000.h5 is damaged \(pressure is a link that leads elsewhere\)"
NO_WRITER = r"L0-000000.h5 is damaged \(pressure is stored as no writer of this format does it\)"
CRAFTED = {
    external_link: ELSEWHERE,
    soft_link: ELSEWHERE,
    external_dataset: NO_WRITER,
    virtual_dataset: NO_WRITER,
    objects: "L0-000000.h5 is damaged",
    references: "L0-000000.h5 is damaged",
    opaque_pickle: NO_WRITER,
    group: "L0-000000.h5 is damaged",
    beyond_memory: r"L0-000000.h5: pressure declares the shape \(10000000, 10000000\), above half of the",
}


@pytest.mark.parametrize("craft", CRAFTED, ids=lambda f: f.__name__)
def test_a_crafted_field_is_refused_by_name_before_anything_is_read(folder, secret, craft):
    path = fields_path(folder, 0, 0)
    with forged(path) as file:
        craft(file, secret)
    for look in (lambda: read_fields(path), lambda: read_fields(path, ("pressure",))):
        with pytest.raises(rs.RecordError, match=CRAFTED[craft]) as refused:
            look()
        assert "\n" not in str(refused.value)


def test_what_belongs_to_no_member_is_not_looked_at(folder, secret):
    path = member_path(folder, 0, 0)
    with forged(path) as file:
        file["more/deep"] = h5py.ExternalLink(str(secret), "/pressure")
        file["\x1b]0;owned\x07"] = file["/"]  # a cycle
    assert read_file(path).index == 0
    assert rs.open_run(folder).members.sound(0) == [0, 1]


def test_what_is_refused_stays_where_it_is(folder, secret):
    path = member_path(folder, 0, 0)
    with forged(path) as file:
        del file["L0/numbers"]
        file["L0/numbers"] = h5py.ExternalLink(str(secret), "/pressure")
    before = path.read_bytes(), secret.read_bytes()
    with pytest.raises(rs.RecordError, match=r"L0-000000.h5 is damaged \(numbers is a link"):
        rs.open_run(folder)
    run = rs.open_run(folder, damaged="skip")
    assert (path.read_bytes(), secret.read_bytes()) == before
    assert list(run.damaged) == ["L0-000000.h5"]
    assert run.members.sound(0) == [1]
    with pytest.raises(ValueError, match="has kept no fields"):
        run.fields("pressure")


def test_a_pipe_is_refused_and_does_not_block(folder):
    (folder / "run.json").unlink()
    os.mkfifo(folder / "run.json")
    with pytest.raises(rs.RecordError, match="is a folder, a pipe or a device"):
        rs.open_run(folder)


def test_claims_from_elsewhere_neither_block_nor_crash(folder, quick, soon):
    place = folder / "claims"
    place.mkdir()
    os.mkfifo(place / "process-pipe")
    os.mkfifo(place / "L0-000002")
    (place / "process-folder").mkdir()
    (place / "L0-000003").write_text("../../../etc/passwd")
    for name, pid in (
        ("a", 10**30),
        ("b", "x"),
        ("c", None),
        ("d", [1]),
        ("e", -1),
        ("\x1b[31m", 1),
    ):
        (place / f"process-{name}").write_text(f"0\n\x1b[31m {pid} {claims.process_space()}\n")
    (place / "letter.txt").write_text("dear")
    assert claims.writer(folder) is None
    assert rs.run(quick, folder, max_realizations=4).realizations == 4
    assert (place / "letter.txt").read_text() == "dear"


def test_fields_may_be_kept_from_a_resumed_run_on(whole, folder):
    scene = replace(whole.scene, numerics=replace(whole.scene.numerics, keep_fields=3))
    assert rs.run(scene, folder, max_realizations=3).realizations == 3
    assert rs.open_run(folder).members.sound(0) == [0, 1, 2]


def change(folder, **values):
    """Change a description as somebody does who forges its checksums."""
    path = folder / "run.json"
    description = json.loads(path.read_text()) | values
    del description["checksums"]
    checksums = {key: checksum(value) for key, value in description.items()}
    path.write_text(json.dumps(description | {"checksums": checksums}))


DESCRIPTIONS = {
    "scene": ({"scene": {}}, "run.json and scene.toml are of different scenes"),
    "numerics": ({"numerics": {"levels": []}}, "cannot be opened"),
    "reasons": ({"reasons": [["a", "b"]]}, "cannot be opened"),
    "list": ({"numerics": []}, "cannot be opened"),
}


@pytest.mark.parametrize("case", DESCRIPTIONS)
def test_a_description_that_no_writer_makes_is_refused(folder, case):
    values, message = DESCRIPTIONS[case]
    change(folder, **values)
    with pytest.raises(rs.RecordError, match=message):
        rs.open_run(folder)


def test_endless_and_bottomless_descriptions_are_refused(folder):
    (folder / "run.json").write_text("[" * 100_000)
    with pytest.raises(rs.RecordError, match="run.json is damaged"):
        rs.open_run(folder)
    (folder / "run.json").write_text(" " * (1 << 20) + "{}")
    with pytest.raises(rs.RecordError, match="run.json has .* MiB, above the 1 MiB"):
        rs.open_run(folder)


@pytest.mark.parametrize("key", ["psd_file", "topography"])
def test_the_scene_of_a_run_reads_no_other_file(folder, tmp_path, key):
    (tmp_path / "secret.csv").write_text("1e4, 1e-20\n1e5, 1e-24\n")
    text = (folder / "scene.toml").read_text()
    (folder / "scene.toml").write_text(
        text.replace("[surface]", f'[surface]\n{key} = "../secret.csv"')
    )
    with pytest.raises(rs.RecordError, match=f"surface.{key}"):
        rs.open_run(folder)


def test_outputs_stay_where_they_were_asked_for(folder, tmp_path):
    # all names of outputs are the caller's, or of numbers; a title is never one
    text = (folder / "scene.toml").read_text()
    (folder / "scene.toml").write_text(text.replace('"small capped"', '"../../escape"'))
    before = {p for p in tmp_path.rglob("*")}
    export_run(rs.open_run(folder), tmp_path / "out" / "a.h5")
    with pytest.raises(SystemExit):
        main(["plot", str(folder), "pressure"])
    made = {p.relative_to(tmp_path) for p in tmp_path.rglob("*")} - {
        p.relative_to(tmp_path) for p in before
    }
    assert sorted(map(str, made)) == ["out", "out/a.h5", "run-pressure.png"]
    for place in (tmp_path / "a" / ".." / "..", tmp_path / "pressure/../../x"):
        with pytest.raises(ValueError, match="must end in"):
            export_run(rs.open_run(folder), place)
