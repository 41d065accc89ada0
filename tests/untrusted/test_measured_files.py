"""Measured topographies from elsewhere: what leads out of them, runs code or fills the memory is refused by name."""

import gzip
import os
import pickle
import time
import zipfile

import h5py
import numpy as np
import pytest

import roughsim as rs
from roughsim.machine import available_memory
from roughsim.surface.topography.reading import read_scan
from roughsim.untrusted import check_measured_file


def test_other_hdf5_files_may_hold_text_and_soft_links_but_lead_nowhere(tmp_path, secret):
    path = tmp_path / "instrument.h5"
    with h5py.File(path, "w") as file:
        file["name"] = "microscope"
        file["heights"] = np.zeros((4, 4))
        file["alias"] = h5py.SoftLink("/heights")
    check_measured_file(path)
    with h5py.File(path, "r+") as file:
        file["away"] = h5py.ExternalLink(str(secret), "/pressure")
    with pytest.raises(rs.RecordError, match="/away is an external link"):
        check_measured_file(path)


class Attack:
    """Leaves a trace where it is unpickled."""

    def __init__(self, trace):
        self.trace = str(trace)

    def __reduce__(self):
        return os.mkdir, (self.trace,)


@pytest.mark.parametrize("kind", ["npy", "npz", "pickle"])
def test_pickles_are_not_unpacked(tmp_path, kind):
    pytest.importorskip("SurfaceTopography")
    trace, path = tmp_path / "trace", tmp_path / f"scan.{kind}"
    array = np.array([[Attack(trace)] * 8] * 8, dtype=object)
    if kind == "npy":
        np.save(path, array, allow_pickle=True)
    elif kind == "npz":
        np.savez(path, heights=array, allow_pickle=True)
    else:
        path.write_bytes(pickle.dumps(array))
    plain = {"size": (1e-3, 1e-3), "unit": "m"} if kind == "npy" else {}
    with pytest.raises(rs.RecordError) as refused:
        read_scan(path, **plain)
    assert str(path) in str(refused.value)
    assert ("holds pickled Python objects" in str(refused.value)) == (
        kind != "npz"
    )  # that one its reader refuses
    assert not trace.exists()


def test_a_zip_that_unpacks_beyond_memory_is_refused(tmp_path, memory):
    path = tmp_path / "scan.x3p"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("bindata/data.bin", bytes(40_000_000))
    assert path.stat().st_size < 100_000
    memory(6e7)
    with pytest.raises(
        rs.RecordError, match="unpacks to 0.04 GB, above half of the available memory"
    ):
        check_measured_file(path)


def test_a_file_beyond_memory_is_refused(tmp_path):
    path = tmp_path / "scan.sur"
    with open(path, "wb") as file:
        file.truncate(int(0.13 * available_memory().amount))  # sparse: it takes no room on the disk
    with pytest.raises(
        rs.RecordError, match="above an eighth of the available memory; crop it first"
    ):
        check_measured_file(path)


@pytest.mark.slow
def test_a_reader_that_computes_too_long_is_ended(tmp_path, monkeypatch):
    # 46 kB that unpack to 10 MB of zeros: some reader of the forty computes on them for a quarter of a minute
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    path = tmp_path / "zeros.gz"
    path.write_bytes(gzip.compress(bytes(10_000_000)))
    monkeypatch.setattr("roughsim.surface.topography.reading._LEAST_SECONDS", 0.5)
    began = time.process_time()
    with pytest.raises(
        rs.RecordError,
        match=r"zeros.gz cannot be read: the library did not come back in 1 s of comp",
    ):
        read_scan(path)
    assert time.process_time() - began < 0.5
