"""The exported file: answers, every number of every member, and the kept fields, with axes and units."""

import hashlib
import os
import subprocess
import sys
from dataclasses import replace

import h5py
import numpy as np
import pytest
from export_cases import UNITS
from stored_cases import read_member

import roughsim as rs
from roughsim.cli import main
from roughsim.results.export import export_run, rounded


def test_each_level_holds_every_number_of_every_member(kept_run, file):
    with h5py.File(file) as stored:
        group = stored["members"]
        for level in range(3):
            for index in range(3):
                member = read_member(kept_run.folder, level, index)
                for name, values in member.numbers.items():
                    share = 0.9 if "flash" in name else 1.0
                    np.testing.assert_allclose(
                        group[name][level, index], np.squeeze(values * share), rtol=1e-15
                    )
                np.testing.assert_array_equal(
                    group[f"stress_spectrum_L{level}"][index], member.moments[0].spectrum
                )
                np.testing.assert_array_equal(
                    group[f"wavenumber_L{level}"], member.moments[0].wavenumber
                )
        assert list(group["column"].asstr()) == ["smoothed", "capped", "capped"]
        np.testing.assert_array_equal(group["q_max"], [5e4, 5e4, 1e5])
        np.testing.assert_array_equal(stored["results/speed"], [0.0, 0.1, 35.0])
        for name in ("heights", "pressure"):
            for index, field in kept_run.fields(name):
                np.testing.assert_array_equal(group[f"{name}_L2"][index], field)


def test_the_answers_are_those_that_the_comparison_prints(kept_run, file):
    rows = rs.compare(kept_run).rows
    with h5py.File(file) as whole:
        stored = whole["results"]
        columns = [text.decode() for text in stored["column"]]
        parts = [text.decode() for text in stored["part"]]
        ratios = ["smoothed_over_theory", "capped_over_smoothed"]
        theories = ["theory", "theory_same_modes", "theory_at_cut_off", "calibrated"]
        assert columns == [*theories, "smoothed", "capped", *ratios]
        for row in rows:
            place = () if row.speed is None else (kept_run.scene.speeds.index(row.speed),)
            values = stored[row.observable][(slice(None), *place)]
            errors = stored[f"{row.observable}_total_error"][(slice(None), *place)]
            cells = {**row.columns, **row.ratios}
            shown = [*row.theories.values(), *(cell.mean for cell in cells.values())]
            np.testing.assert_allclose(values, shown, rtol=1e-12)
            totals = [cell.total_error for cell in cells.values()]
            np.testing.assert_allclose(errors[4:], totals, rtol=1e-12)
            assert np.isnan(errors[0])
            budget = stored[f"{row.observable}_part"][(slice(None), slice(None), *place)]
            for name, cell in cells.items():
                lacking = np.isnan(budget[:, columns.index(name)])
                if cell.mean != 0.0 and np.isfinite(cell.mean):
                    assert [part for part, lacks in zip(parts, lacking, strict=True) if lacks] == [
                        part for part in parts if part in cell.unknown
                    ]
            notes = stored[f"{row.observable}_note"].asstr()[(slice(None), *place)]
            assert row.note in notes.tolist()[4:6]


def test_the_temperature_map_is_that_of_the_plot_at_the_highest_speed(kept_run, file):
    with h5py.File(file) as stored:
        for level in (0, 2):  # the finest of each column
            maps = stored[f"members/temperature_L{level}"]
            assert (maps.attrs["units"], maps.attrs["speed"]) == ("K", 35.0)
            np.testing.assert_array_equal(
                maps[1], kept_run.field(level, 1, "temperature", speed=35.0)
            )
            # the mean over the cell is the background, so it is zero to rounding
            assert abs(maps[1].mean(dtype=float)) < 1e-5 * maps[1].max()
        assert "temperature_L1" not in stored["members"]


def test_a_run_at_rest_has_no_temperature_map(quick, tmp_path):
    scene = replace(quick, sliding=replace(quick.sliding, speed=(0.0,)))
    with h5py.File(
        export_run(rs.run(scene, tmp_path / "rest", max_realizations=1), tmp_path / "rest.h5")
    ) as stored:
        assert "pressure_L0" in stored["members"]
        assert "temperature_L0" not in stored["members"]


def test_the_file_says_in_words_what_is_in_it(kept_run, file):
    with h5py.File(file) as stored:
        words = stored.attrs["README"]
        groups = [name for name in stored if isinstance(stored[name], h5py.Group)]
        for name in (
            *groups,
            *(text.decode() for text in stored["results/column"]),
            "heat_share_used",
        ):
            assert name in words
        assert "small capped: 3 realizations" in words
        assert (stored.attrs["realizations"], stored.attrs["failed"]) == (3, 0)


def test_every_array_has_its_axes_and_unit_and_no_long_name(file):
    with h5py.File(file) as stored:
        for name, unit in UNITS.items():
            assert stored[name].attrs["units"] == unit
        arrays = []
        stored.visititems(
            lambda _, entry: arrays.append(entry) if isinstance(entry, h5py.Dataset) else None
        )
        assert len(arrays) > 90
        for array in arrays:
            assert "long_name" not in array.attrs
            if array.is_scale:
                continue
            for number, length in enumerate(array.shape):
                assert array.dims[number][0].shape == (length,)
        np.testing.assert_allclose(stored["members/x_L2"], np.arange(128) * 2e-3 / 128)
        assert "heat_partition = 0.9" in stored.attrs["scene"]


def test_an_oblong_cell_has_its_own_axes(quick, tmp_path):
    levels = ({"column": "capped", "shape": [48, 32], "q_max": 4e4},)
    scene = replace(
        quick, numerics=replace(quick.numerics, lengths=(3e-3, 2e-3 * 1.1), levels=levels)
    )
    run = rs.run(scene, tmp_path / "oblong", max_realizations=1)
    with h5py.File(export_run(run, tmp_path / "oblong.nc")) as stored:
        assert stored["members/pressure_L0"].shape == (1, 48, 32)
        np.testing.assert_allclose(stored["members/x_L0"], np.arange(48) * 3e-3 / 48)
        np.testing.assert_allclose(stored["members/y_L0"], np.arange(32) * 2.2e-3 / 32)


def test_viewers_draw_the_flash_temperature_with_its_error_beside_both_theories_first(
    kept_run, file
):
    with h5py.File(file) as stored:
        place = stored
        while "default" in place.attrs:
            place = place[place.attrs["default"]]
        assert place.attrs["NX_class"] == "NXdata"
        assert list(place.attrs["axes"]) == ["speed"]
        signal = place.attrs["signal"]
        assert [signal, *place.attrs["auxiliary_signals"]] == [
            "capped",
            "theory",
            "theory_same_modes",
            "theory_at_cut_off",
            "calibrated",
            "smoothed",
        ]
        estimate = kept_run.estimate("flash_temperature")
        np.testing.assert_array_equal(place[signal], estimate.mean)
        np.testing.assert_array_equal(place[f"{signal}_errors"], estimate.total_error)
        maps = stored["entry/pressure_L2"]
        assert maps[maps.attrs["signal"]] == stored["members/pressure_L2"]
        assert list(maps.attrs["axes"]) == ["kept_realization_L2", "x_L2", "y_L2"]
        assert all(name in maps for name in maps.attrs["axes"])


def test_a_run_without_fields_has_answers_and_numbers(quick, tmp_path):
    scene = replace(quick, numerics=replace(quick.numerics, keep_fields=0))
    run = rs.run(scene, tmp_path / "none", max_realizations=1)
    with h5py.File(export_run(run, tmp_path / "none.h5")) as stored:
        assert list(stored["entry"]) == ["flash_temperature"]
        assert not any(
            f"{name}_L0" in stored["members"]
            for name in ("pressure", "heights", "temperature", "x")
        )


@pytest.mark.parametrize("bits", [1, 4, 7, 12, 22, 23])
def test_rounding_errs_by_half_a_unit_in_the_last_bit_kept(bits):
    rng = np.random.default_rng(5)
    values = (rng.choice([-1, 1], 50_000) * np.exp(rng.uniform(-60, 60, 50_000))).astype(np.float32)
    there = rounded(values, bits)
    error = np.abs(there.astype(float) / values - 1)
    assert error.max() <= 2.0 ** -(bits + 1)
    if (
        bits < 22
    ):  # and no more bits than were asked for: the worst case is half a unit just above a power of two
        assert error.max() > 0.98 / (2.0 ** (bits + 1) + 1)
    mantissa, _ = np.frexp(there.astype(float))
    np.testing.assert_array_equal(mantissa * 2.0 ** (bits + 1) % 1, 0.0)
    np.testing.assert_array_equal(rounded(there, bits), there)
    assert abs(np.mean(there.astype(float) / values - 1)) < 5 * 2.0**-bits / np.sqrt(
        values.size
    )  # without drift


def test_ties_go_to_even_and_zero_stays():
    values = np.array([1.0, 1.25, 1.75, 0.0, -1.25, 1.9], np.float32)  # one bit: 1, 1.5, 2
    np.testing.assert_array_equal(rounded(values, 1), [1.0, 1.0, 2.0, 0.0, -1.0, 2.0])


def test_fewer_bits_shrink_the_file(kept_run, file, tmp_path):
    small = export_run(kept_run, tmp_path / "small.h5", bits=6)
    sizes = []
    with h5py.File(file) as whole, h5py.File(small) as less:
        for name in ("members/heights_L2", "members/pressure_L2"):
            a, b = whole[name][()].astype(float), less[name][()]
            assert np.abs(b - a).max() > 0
            assert np.all(np.abs(b - a) <= 2.0**-7 * np.abs(a))
            assert less[name].attrs["_QuantizeBitRoundNumberOfSignificantBits"] == 6
            sizes.append((whole[name].id.get_storage_size(), less[name].id.get_storage_size()))
        for name in (
            "results/flash_temperature",
            "members/stress_spectrum_L2",
            "members/wavenumber_L2",
        ):  # numbers keep all digits
            np.testing.assert_array_equal(less[name], whole[name])
    assert sizes[0][1] < 0.6 * sizes[0][0]
    assert small.stat().st_size < file.stat().st_size


@pytest.mark.parametrize("bits", [0, 24, 2.5, True])
def test_bits_that_a_float32_does_not_have_are_refused(kept_run, tmp_path, bits):
    with pytest.raises(ValueError, match="bits = .* must be a whole number from 1 to 23"):
        export_run(kept_run, tmp_path / "x.h5", bits=bits)


def test_the_file_is_whole_or_not_there(kept_run, tmp_path):
    with pytest.raises(ValueError, match="must end in .h5, .hdf5, .nc"):
        export_run(kept_run, tmp_path / "x.zip")
    (tmp_path / "folder.h5").mkdir()
    with pytest.raises(OSError, match="cannot write .*folder.h5"):
        export_run(kept_run, tmp_path / "folder.h5")
    assert [p.name for p in tmp_path.iterdir()] == ["folder.h5"]


@pytest.mark.slow
@pytest.mark.parametrize("room", [1_000, 99_000])
def test_a_full_disk_is_an_error_and_leaves_what_was_there(kept_run, tmp_path, room):
    (tmp_path / "out.h5").write_text("what was there")
    code = (
        "import resource, signal, sys, roughsim as rs; from roughsim.results.export import export_run;"
        "run = rs.open_run(sys.argv[1]);"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[3]), resource.RLIM_INFINITY));"
        "export_run(run, sys.argv[2])"
    )
    words = [sys.executable, "-c", code, str(kept_run.folder), str(tmp_path / "out.h5"), str(room)]
    done = subprocess.run(words, capture_output=True, text=True, check=False, env={**os.environ})
    assert done.returncode == 1
    assert "OSError" in done.stderr.splitlines()[-1]
    assert "out.h5" in done.stderr.splitlines()[-1]
    assert [p.name for p in tmp_path.iterdir()] == ["out.h5"]
    assert (tmp_path / "out.h5").read_text() == "what was there"


def test_the_command_line_exports(kept_run, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["export", str(kept_run.folder), "-o", str(tmp_path / "a.h5"), "--bits", "8"])
    assert ended.value.code == 0
    assert "a.h5, " in capsys.readouterr().err
    assert h5py.is_hdf5(tmp_path / "a.h5")


def test_readers_by_reference_find_every_array(file):
    # kerchunk and others know gzip and shuffle, not fletcher32
    filters = {}
    with h5py.File(file) as opened:
        opened.visititems(
            lambda name, one: filters.update({name: getattr(one, "fletcher32", False)})
        )
    assert len(filters) > 50
    assert not any(filters.values())


def test_the_last_line_seals_the_file(kept_run, tmp_path):
    content = export_run(kept_run, tmp_path / "one.h5").read_bytes()
    data, name, digest = content[:-65], content[:-65].rpartition(b"\n")[2], content[-65:]
    assert name == b"roughsim one.h5 sha256 "
    assert digest == f"{hashlib.sha256(data).hexdigest()}\n".encode()
