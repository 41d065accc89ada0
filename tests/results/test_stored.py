"""estimates.json: what a run says when it ends is read back to the bit, and never an older or a foreign answer."""

import json
import os
import shutil
from dataclasses import fields

import numpy as np
import pytest

import roughsim as rs
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.results import means, run
from roughsim.results.stored import ESTIMATES
from roughsim.store.disk import checksum
from roughsim.store.member_files import member_path


@pytest.fixture
def stored(kept_run, tmp_path):
    """A copy of the folder of a finished run."""
    return shutil.copytree(kept_run.folder, tmp_path / "run")  # with the times of the files


@pytest.fixture
def computed(monkeypatch):
    """The names of the observables that are estimated anew."""
    true, names = means.Means._estimate, []

    def watched(self, name, column, share, counts=None):
        if counts is None:  # else a round is judged
            names.append(name)
        return true(self, name, column, share, counts)

    monkeypatch.setattr(means.Means, "_estimate", watched)
    return names


def all_estimates(folder):
    opened = rs.open_run(folder)
    return {column: opened.estimates(column) for column in opened.numerics.columns}


def assert_the_same(one, other):
    for key in fields(one):
        a, b = getattr(one, key.name), getattr(other, key.name)
        if key.name == "budget":
            assert list(a) == list(b)
            a, b = list(a.values()), list(b.values())
        np.testing.assert_array_equal(a, b)


def test_what_is_read_back_is_what_was_computed_to_the_bit(stored, computed):
    read = all_estimates(stored)
    assert computed == []
    (stored / ESTIMATES).unlink()
    fresh = all_estimates(stored)
    assert len(computed) == 2 * len(OBSERVABLES)
    for column, estimates in fresh.items():
        for name, estimate in estimates.items():
            assert_the_same(read[column][name], estimate)


def test_the_file_is_plain_json_with_means_and_total_errors(kept_run):
    def refuse(word):
        raise AssertionError(word)  # NaN and Infinity are not JSON

    content = json.loads((kept_run.folder / ESTIMATES).read_text(), parse_constant=refuse)
    assert content["speed"] == [0.0, 0.1, 35.0]
    assert (content["realizations"], content["failed"]) == (3, 0)
    values, estimate = content["estimates"]["capped"]["flash_temperature"], kept_run.estimate("flash_temperature")
    assert (values["unit"], values["n"]) == ("K", 3)
    assert values["mean"] == estimate.mean.tolist()
    assert values["total_error"] == estimate.total_error.tolist()
    assert content["estimates"]["capped"]["slope_length"]["mean"][0] == "inf"  # at rest


def other_version(folder, monkeypatch):
    monkeypatch.setattr(run, "version", lambda _: "0.0.1")


def another_time(folder, monkeypatch):
    os.utime(folder / "realizations" / "L1-000001.h5")


def another_share(folder, monkeypatch):
    path = folder / ESTIMATES
    content = json.loads(path.read_text())
    content["made_by"]["run"] = "0123456789abcdef"
    del content["checksum"]
    path.write_text(json.dumps(content | {"checksum": checksum(content)}))


def a_changed_mean(folder, monkeypatch):
    path = folder / ESTIMATES
    content = json.loads(path.read_text())
    content["estimates"]["capped"]["flash_temperature"]["mean"][2] *= 2
    path.write_text(json.dumps(content))


def forged(change):
    def spoil(folder, monkeypatch):
        path = folder / ESTIMATES
        content = json.loads(path.read_text())
        change(content["estimates"]["capped"])
        del content["checksum"]
        path.write_text(json.dumps(content | {"checksum": checksum(content)}))

    return spoil


def half_a_file(folder, monkeypatch):
    path = folder / ESTIMATES
    path.write_bytes(path.read_bytes()[:1000])


def a_folder(folder, monkeypatch):
    (folder / ESTIMATES).unlink()
    (folder / ESTIMATES).mkdir()


@pytest.mark.parametrize(
    "spoil",
    [
        other_version,
        another_time,
        another_share,
        a_changed_mean,
        half_a_file,
        a_folder,
        forged(lambda c: c["flash_temperature"]["mean"].pop()),
        forged(lambda c: c["flash_temperature"].update(mean=["", 1, 2])),
        forged(lambda c: c["flash_temperature"].update(unit="m")),
        forged(lambda c: c["flash_temperature"]["budget"].update(luck=[0, 0, 0])),
        forged(lambda c: c.update(warmth=c["flash_temperature"])),
    ],
)
def test_what_is_not_of_these_members_and_this_code_is_computed_anew(stored, computed, monkeypatch, spoil):
    before = rs.open_run(stored).estimate("flash_temperature")
    spoil(stored, monkeypatch)
    computed.clear()
    after = rs.open_run(stored).estimate("flash_temperature")
    assert computed == ["flash_temperature"]
    assert_the_same(after, before)


def test_a_run_that_goes_on_says_what_all_its_members_say(stored, computed):
    scene = rs.open_run(stored).scene
    longer = rs.run(scene, stored, max_realizations=4)
    assert longer.estimate("flash_temperature").n == 4
    assert json.loads((stored / ESTIMATES).read_text())["estimates"]["capped"]["flash_temperature"]["n"] == 4
    member_path(stored, 1, 3).unlink()
    computed.clear()
    assert rs.open_run(stored).estimate("flash_temperature").n == 3
    assert computed == ["flash_temperature"]


def test_a_run_that_ended_before_is_not_estimated_again(stored, computed):
    rs.run(rs.open_run(stored).scene, stored, max_realizations=3)
    assert computed == []


def test_a_damaged_member_that_is_left_out_takes_the_stored_estimates_with_it(stored, computed):
    path = stored / "realizations" / "L2-000001.h5"
    path.write_bytes(path.read_bytes()[:-100])
    left = rs.open_run(stored, damaged="skip")
    assert len(left.pairs()[1].sample.rows) == 2
    assert np.isfinite(left.estimate("flash_temperature").mean).all()
    assert computed == ["flash_temperature"]


def test_a_folder_that_takes_no_files_ends_no_run(quick, tmp_path, monkeypatch):
    from roughsim.results import stored as module

    def refuse(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(module, "place_bytes", refuse)
    done = rs.run(quick, tmp_path / "full", max_realizations=1)
    assert done.realizations == 1
    assert not (tmp_path / "full" / ESTIMATES).exists()


def test_a_run_without_a_sound_member_leaves_no_estimates(quick, tmp_path, monkeypatch):
    from roughsim.ensemble import workers

    def fail(*_):
        raise rs.ConvergenceError("contact solve stalled: residual 0.1", 0.1, 7)

    monkeypatch.setattr(workers, "solve_problem", fail)
    done = rs.run(quick, tmp_path / "stalled", max_realizations=2)
    assert (done.realizations, done.failed) == (2, 2)
    assert not (done.folder / ESTIMATES).exists()
