"""Fields, xarray and the exported file: what was stored comes back with names, axes and units, in every reader."""

import os
import shutil
import subprocess
import sys
from dataclasses import replace

import h5py
import numpy as np
import pytest

import roughsim as rs
from roughsim.cli import main
from roughsim.results.export import export_run, rounded
from roughsim.store.member_files import member_path, read_member, write_member


@pytest.fixture(scope="module")
def kept_run(capped_scene, tmp_path_factory):
    """Three realizations, the fields of two kept."""
    scene = replace(capped_scene, numerics=replace(capped_scene.numerics, keep_fields=2))
    return rs.run(scene, tmp_path_factory.mktemp("runs") / "kept", max_realizations=3)


@pytest.fixture(scope="module")
def file(kept_run, tmp_path_factory):
    return export_run(kept_run, tmp_path_factory.mktemp("files") / "new" / "kept.h5")


def test_fields_stream_what_is_stored(kept_run):
    for column, level in (("smoothed", 0), ("capped", 2), (None, 2)):  # the finest level of each
        for name in ("heights", "pressure"):
            rows = list(kept_run.fields(name, column))
            assert [index for index, _ in rows] == [0, 1]
            for index, field in rows:
                with h5py.File(member_path(kept_run.folder, level, index)) as stored:
                    np.testing.assert_array_equal(field, stored[f"entry/fields/{name}"][()])
                assert field.dtype == np.float32


def test_heat_flux_carries_the_frictional_power(kept_run):
    # force balance: the mean pressure is 90 MPa, so μσ₀|v| = 0.11 · 90e6 · 35 W/m²; float32 pressure, tolerance 1e-4
    for speed in (35.0, -35.0):
        for _, flux in kept_run.fields("heat_flux", speed=speed):
            assert flux.dtype == np.float32
            assert flux.mean(dtype=float) == pytest.approx(0.11 * 90e6 * 35, rel=1e-4)


def test_temperatures_are_those_of_the_share_of_the_heat(kept_run):
    scene, grid = kept_run.scene, kept_run.numerics.grid(2)
    pressure = dict(kept_run.fields("pressure"))
    for speed in (35.0, 7.0):  # 7 m/s has no moments in this run
        for index, field in kept_run.fields("temperature", speed=speed, direction=0.4):
            flux = 0.11 * speed * pressure[index].astype(float)
            heat = {"conductivity": 30.0, "diffusivity": 30.0 / (7900 * 500), "direction": 0.4}
            whole = rs.sliding_temperature(flux, grid, speed=speed, **heat)
            assert field.dtype == np.float32
            np.testing.assert_allclose(field, 0.9 * whole, atol=1e-5 * np.abs(whole).max())
    assert scene.sliding.heat_partition == 0.9


def test_the_slid_distance_of_the_numerics_is_used(kept_run):
    far = rs.open_run(kept_run.folder)
    far.numerics = replace(far.numerics, slid_distance=1e-5)
    (_, short), (_, half) = (
        next(far.fields("temperature", speed=35.0)),
        next(kept_run.fields("temperature", speed=35.0)),
    )
    assert short.std() < 0.5 * half.std()  # after 10 µm the body is still cold


def test_the_hot_spot_trails_where_the_source_came_from(kept_run):
    # heat lies behind the source: T at a distance behind the contact exceeds T as far ahead
    pressure = next(kept_run.fields("pressure"))[1].astype(float)
    for speed, direction, axis, sign in ((35.0, 0.0, 0, 1), (-35.0, 0.0, 0, -1), (35.0, np.pi / 2, 1, 1)):
        temperature = next(kept_run.fields("temperature", speed=speed, direction=direction))[1]
        behind = (temperature * np.roll(pressure, -6 * sign, axis)).mean()  # pressure taken 6 points ahead
        ahead = (temperature * np.roll(pressure, 6 * sign, axis)).mean()
        assert behind > ahead


def test_the_share_of_other_speeds_is_the_rule_of_the_scene(kept_run, monkeypatch):
    from roughsim import prediction

    assert kept_run.heat_share(7.0) == 0.9
    run = rs.open_run(kept_run.folder)
    run.scene = replace(run.scene, sliding=replace(run.scene.sliding, heat_partition="mean", speed=(1.0, 7.0)))
    run.heat_partition = np.array([0.25, 0.5])
    assert run.heat_share(-7.0) == 0.5
    slow, fast = (run.heat_share(v) for v in (0.01, 90.0))
    assert 0.5 < slow < fast < 1.0  # both bodies alike: half at rest, all of it at high speed
    assert slow == prediction.heat_partition(replace(run.scene, sliding=replace(run.scene.sliding, speed=(0.01,))))[0]


def test_one_field_is_in_memory_at_a_time(kept_run, monkeypatch):
    from roughsim.results import fields

    read = []
    monkeypatch.setattr(fields, "read_field", lambda path, name: read.append(path) or np.zeros((128, 128), np.float32))
    stream = kept_run.fields("pressure")
    assert read == []
    next(stream)
    assert len(read) == 1


WRONG_FIELDS = {
    "unknown": (("temp",), {}, "name = 'temp' is no field; choose one of heights, pressure, heat_flux, temperature"),
    "no speed": (("temperature",), {}, "speed is missing"),
    "useless speed": (("heights",), {"speed": 1.0}, "heights does not depend on it"),
    "speed": (("heat_flux",), {"speed": np.nan}, "speed = nan m/s must be finite"),
    "direction": (("temperature",), {"speed": 1.0, "direction": np.inf}, "direction = inf"),
    "column": (("heights", "elastic"), {}, "column = 'elastic' is not in this run"),
}


@pytest.mark.parametrize("case", WRONG_FIELDS)
def test_wrong_questions_are_refused_before_anything_is_read(kept_run, case):
    words, options, message = WRONG_FIELDS[case]
    with pytest.raises(ValueError, match=message):
        kept_run.fields(*words, **options)  # at once, not at the first next()


def test_fields_that_were_not_kept_can_be_had_as_the_error_says(quick, tmp_path):
    scene = replace(quick, numerics=replace(quick.numerics, keep_fields=0))
    run = rs.run(scene, tmp_path / "none", max_realizations=1)
    with pytest.raises(ValueError, match="--keep-fields 1.*rs.realize") as refused:
        run.fields("pressure")
    advice = str(refused.value).partition("recompute one: ")[2]
    one = eval(advice, {"rs": rs, "run": run})  # what the error says can be typed
    assert one.contact.pressure.shape == (32, 32)


def test_a_damaged_field_is_never_shown(quick, tmp_path):
    run = rs.run(quick, tmp_path / "run", max_realizations=1)
    path = member_path(run.folder, 0, 0)
    with h5py.File(path, "r+") as stored:
        stored["entry/fields/pressure"][3, 4] += 1.0
    with pytest.raises(rs.RecordError, match="L0-000000.h5 is damaged .*SHA-256 of its pressure"):
        list(run.fields("pressure"))
    with pytest.raises(rs.RecordError, match="is damaged"):
        export_run(run, tmp_path / "out.h5")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run"]


def test_the_file_holds_every_number_of_every_member(kept_run, file):
    with h5py.File(file) as stored:
        for level in range(3):
            for index in range(3):
                member = read_member(member_path(kept_run.folder, level, index))
                for name, values in member.numbers.items():
                    share = 0.9 if "flash" in name else 1.0
                    np.testing.assert_allclose(stored[name][level, index], np.squeeze(values * share), rtol=1e-15)
                np.testing.assert_array_equal(stored[f"stress_spectrum_L{level}"][index], member.spectrum)
                np.testing.assert_array_equal(stored[f"wavenumber_L{level}"], member.wavenumber)
        assert [text.decode() for text in stored["column"]] == ["smoothed", "capped", "capped"]
        np.testing.assert_array_equal(stored["q_max"], [5e4, 5e4, 1e5])
        np.testing.assert_array_equal(stored["speed"], [0.0, 0.1, 35.0])
        for name in ("heights", "pressure"):
            for index, field in kept_run.fields(name):
                np.testing.assert_array_equal(stored[f"{name}_L2"][index], field)


def test_the_mean_of_the_finest_level_is_mean_plus_bias_of_the_estimate(kept_run, file):
    estimate = kept_run.estimate("flash_temperature")
    with h5py.File(file) as stored:
        mean = stored["flash_temperature"][2].mean(axis=0)
    np.testing.assert_allclose(mean[1:], (estimate.mean + estimate.bias)[1:], rtol=1e-12)


UNITS = {
    "flash_temperature": "K", "flash_gradient": "K/m", "flash_laplacian": "K/m^2", "contact_fraction": "1",
    "pressure_variance": "Pa^2", "speed": "m/s", "q_max": "1/m", "pressure_L2": "Pa", "heights_L0": "m", "x_L1": "m",
}  # fmt: skip


def test_every_array_has_its_axes_and_unit_and_no_long_name(file):
    with h5py.File(file) as stored:
        for name, unit in UNITS.items():
            assert stored[name].attrs["units"] == unit
        arrays = [entry for entry in stored.values() if isinstance(entry, h5py.Dataset)]
        assert len(arrays) > 30
        for array in arrays:
            assert "long_name" not in array.attrs
            if array.is_scale:
                continue
            for number, length in enumerate(array.shape):
                assert array.dims[number][0].shape == (length,)
        np.testing.assert_allclose(stored["x_L2"], np.arange(128) * 2e-3 / 128)
        assert "heat_partition = 0.9" in stored.attrs["scene"]


def test_an_oblong_cell_has_its_own_axes(quick, tmp_path):
    levels = ({"column": "capped", "shape": [48, 32], "q_max": 4e4},)
    scene = replace(quick, numerics=replace(quick.numerics, lengths=(3e-3, 2e-3 * 1.1), levels=levels))
    run = rs.run(scene, tmp_path / "oblong", max_realizations=1)
    with h5py.File(export_run(run, tmp_path / "oblong.nc")) as stored:
        assert stored["pressure_L0"].shape == (1, 48, 32)
        np.testing.assert_allclose(stored["x_L0"], np.arange(48) * 3e-3 / 48)
        np.testing.assert_allclose(stored["y_L0"], np.arange(32) * 2.2e-3 / 32)


def test_viewers_find_the_finest_pressure_first(file):
    with h5py.File(file) as stored:
        place = stored
        while "default" in place.attrs:
            place = place[place.attrs["default"]]
        assert place.attrs["NX_class"] == "NXdata"
        signal = place[place.attrs["signal"]]
        assert signal == stored["pressure_L2"]
        assert list(place.attrs["axes"]) == ["kept_realization", "x_L2", "y_L2"]
        assert all(name in place for name in place.attrs["axes"])


def test_a_run_without_fields_shows_its_temperatures(quick, tmp_path):
    scene = replace(quick, numerics=replace(quick.numerics, keep_fields=0))
    run = rs.run(scene, tmp_path / "none", max_realizations=1)
    with h5py.File(export_run(run, tmp_path / "none.h5")) as stored:
        assert stored["entry"].attrs["default"] == "flash_temperature"
        assert not any(name.startswith(("pressure_L", "heights_L", "x_L", "kept")) for name in stored)


@pytest.mark.parametrize("bits", [1, 4, 7, 12, 22, 23])
def test_rounding_errs_by_half_a_unit_in_the_last_bit_kept(bits):
    rng = np.random.default_rng(5)
    values = (rng.choice([-1, 1], 50_000) * np.exp(rng.uniform(-60, 60, 50_000))).astype(np.float32)
    there = rounded(values, bits)
    error = np.abs(there.astype(float) / values - 1)
    assert error.max() <= 2.0 ** -(bits + 1)
    if bits < 22:  # and no more bits than were asked for: the worst case is half a unit just above a power of two
        assert error.max() > 0.98 / (2.0 ** (bits + 1) + 1)
    mantissa, _ = np.frexp(there.astype(float))
    np.testing.assert_array_equal(mantissa * 2.0 ** (bits + 1) % 1, 0.0)
    np.testing.assert_array_equal(rounded(there, bits), there)
    assert abs(np.mean(there.astype(float) / values - 1)) < 5 * 2.0**-bits / np.sqrt(values.size)  # without drift


def test_ties_go_to_even_and_zero_stays():
    values = np.array([1.0, 1.25, 1.75, 0.0, -1.25, 1.9], np.float32)  # one bit: 1, 1.5, 2
    np.testing.assert_array_equal(rounded(values, 1), [1.0, 1.0, 2.0, 0.0, -1.0, 2.0])


def test_fewer_bits_shrink_the_file(kept_run, file, tmp_path):
    small = export_run(kept_run, tmp_path / "small.h5", bits=6)
    sizes = []
    with h5py.File(file) as whole, h5py.File(small) as less:
        for name in ("heights_L2", "pressure_L2"):
            a, b = whole[name][()].astype(float), less[name][()]
            assert np.abs(b - a).max() > 0
            assert np.all(np.abs(b - a) <= 2.0**-7 * np.abs(a))
            assert less[name].attrs["_QuantizeBitRoundNumberOfSignificantBits"] == 6
            sizes.append((whole[name].id.get_storage_size(), less[name].id.get_storage_size()))
        for name in ("flash_temperature", "stress_spectrum_L2", "wavenumber_L2"):  # numbers keep all digits
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


@pytest.mark.parametrize("room", [1_000, pytest.param(99_000, marks=pytest.mark.slow)])
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


def test_xarray_says_how_to_install_it(kept_run, monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(ImportError, match=r"pip install 'roughsim\[xarray\]'"):
        kept_run.to_xarray()


def test_xarray_has_names_axes_and_units(kept_run):
    pytest.importorskip("xarray")
    data = kept_run.to_xarray()
    assert dict(data.flash_temperature.sizes) == {"level": 3, "realization": 3, "speed": 3}
    for name, unit in UNITS.items():
        assert data[name].attrs["units"] == unit
    assert {"column", "q_max", "level", "speed", "realization"} <= set(data.coords)
    capped = data.flash_temperature.where(data.column == "capped", drop=True)
    estimate = kept_run.estimate("flash_temperature")
    mean = capped.isel(level=-1).mean("realization")
    np.testing.assert_allclose(mean[1:], (estimate.mean + estimate.bias)[1:], rtol=1e-12)


def test_xarray_reads_fields_when_they_are_used(kept_run, monkeypatch):
    pytest.importorskip("xarray")
    from roughsim.results import arrays

    true, read = arrays.read_field, []
    monkeypatch.setattr(arrays, "read_field", lambda path, name: read.append(path.name) or true(path, name))
    data = kept_run.to_xarray()
    assert read == []
    corner = data.pressure_L2.sel(kept_realization=1)[3:9, ::7].values
    assert read == ["L2-000001.h5"]
    fields = dict(kept_run.fields("pressure"))
    np.testing.assert_array_equal(corner, fields[1][3:9, ::7])
    np.testing.assert_array_equal(data.pressure_L2, [fields[0], fields[1]])
    np.testing.assert_array_equal(data.pressure_L2[::-1, 5], [fields[1][5], fields[0][5]])
    np.testing.assert_array_equal(data.pressure_L2[[1], [4, 2]], fields[1][None, [4, 2]])
    assert data.pressure_L2[:0, 3].shape == (0, 128)


def test_stress_spectra_are_read_when_they_are_used(kept_run, monkeypatch):
    pytest.importorskip("xarray")
    from roughsim.results import arrays

    true, read = arrays.read_member, []
    monkeypatch.setattr(arrays, "read_member", lambda path: read.append(path.name) or true(path))
    data = kept_run.to_xarray()
    assert read == [f"L{level}-000000.h5" for level in range(3)]  # the wavenumbers of each level
    read.clear()
    row = data.stress_spectrum_L1[2].values
    assert read == ["L1-000002.h5"]
    np.testing.assert_array_equal(row, true(member_path(kept_run.folder, 1, 2)).spectrum)
    assert data.stress_spectrum_L1[1:, 3:5].shape == (2, 2)


def test_a_field_of_another_grid_is_not_shown(kept_run, tmp_path):
    shutil.copytree(kept_run.folder, tmp_path / "run")
    path = member_path(tmp_path / "run", 2, 0)
    one = read_member(path, with_fields=True)
    path.unlink()
    write_member(tmp_path / "run", replace(one, fields={name: f[:, :64] for name, f in one.fields.items()}))
    run = rs.open_run(tmp_path / "run")
    with pytest.raises(rs.RecordError, match=r"shape \(128, 64\), but this run has \(128, 128\)"):
        next(run.fields("pressure"))
    with pytest.raises(rs.RecordError, match=r"shape \(128, 64\)"):
        export_run(run, tmp_path / "out.h5")


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_the_file_opens_in_xarray_as_the_run_itself(kept_run, file, engine):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip({"netcdf4": "netCDF4"}.get(engine, engine))
    with xarray.open_dataset(file, engine=engine) as stored:  # warnings are errors here
        xarray.testing.assert_equal(stored, kept_run.to_xarray())
        for name, unit in UNITS.items():
            assert stored[name].attrs["units"] == unit
            assert stored[name].dims == kept_run.to_xarray()[name].dims


def test_a_failed_member_is_nan_and_counted(kept_run):
    xarray = pytest.importorskip("xarray")
    run = rs.open_run(kept_run.folder)
    failed = replace(run.members[1, 2], failure="stalled", numbers={})
    run.members[1, 2] = failed
    data = run.to_xarray()
    assert isinstance(data, xarray.Dataset)
    assert data.converged.values.tolist() == [[1, 1, 1], [1, 1, 0], [1, 1, 1]]
    assert np.isnan(data.flash_temperature[1, 2]).all()
    assert np.isnan(data.stress_spectrum_L1[2]).all()
    assert np.isfinite(data.flash_temperature).sum() == 8 * 3
