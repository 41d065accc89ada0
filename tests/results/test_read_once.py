"""Each file of a member is read once: its stress spectrum stays in memory, up to a bound."""

import os
import pickle
import shutil
import sys
from dataclasses import replace

import numpy as np
import pytest
from summary_cases import COUNT, bits

import roughsim as rs
from roughsim.results import reader
from roughsim.store.member_files import member_path, read_member, write_member


def test_a_comparison_opens_the_file_of_each_member_once(folder):
    opened, watching = [], [True]

    def watched(event, arguments):
        if event == "open" and str(arguments[0]).endswith(".h5") and watching:
            opened.append(os.path.basename(arguments[0]))

    sys.addaudithook(watched)  # sees what NumPy opens too
    rs.compare(rs.open_run(folder)).to_dict()
    watching.clear()
    assert sorted(opened) == sorted(path.name for path in (folder / "realizations").iterdir())


@pytest.mark.parametrize("most", [0, 50_000, 1 << 20])
def test_spectra_are_the_same_however_many_stay_in_memory(folder, whole, most, monkeypatch):
    monkeypatch.setattr(reader, "MOST_KEPT", most)
    run, every = rs.open_run(folder), [level.every for level in whole.numerics.levels]
    assert bits(run) == bits(whole)
    for rows in ([4, 6], [0, 2, 4], list(range(COUNT)), [6]):
        for level, sample in zip(whole.numerics.of_column(whole.column(None)), run.samples(None, rows), strict=True):
            stored = [read_member(member_path(folder, level, k)).spectrum for k in rows if k % every[level] == 0]
            np.testing.assert_array_equal(sample.spectrum, np.reshape(stored, sample.spectrum.shape))


@pytest.mark.slow
def test_a_reader_holds_no_more_spectra_of_500_than_of_50_realizations(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", lambda handle: None)
    monkeypatch.setattr(reader, "MOST_KEPT", 1 << 20)
    wavenumber, spectrum = np.geomspace(1e3, 1e5, 5000), np.random.default_rng(2).random(5000)
    held = {}
    for count in (50, 500):
        other = shutil.copytree(folder, tmp_path / str(count), ignore=shutil.ignore_patterns("L*"))
        for level, every in ((0, 1), (1, 2)):
            one = replace(read_member(member_path(folder, level, 0)), wavenumber=wavenumber)
            for index in range(0, count, every):
                write_member(other, replace(one, index=index, spectrum=spectrum + index))
        run = rs.open_run(other)
        run.max_realizations = count
        run.refresh()
        np.testing.assert_array_equal(run.samples()[0].spectrum, spectrum + np.arange(count)[:, None])
        held[count] = len(pickle.dumps(run._reader))
    assert held[500] - held[50] < 1000 * 1.5 * 450  # rows of numbers; their spectra take 40 kB each
