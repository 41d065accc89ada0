"""A run as an xarray dataset: names, axes and units, and arrays that are read when they are used."""

import contextlib
import pickle
from dataclasses import replace

import numpy as np
import pytest
from export_cases import BOTH, FLAT_UNITS
from some_rows import some
from stored_cases import read_member

import roughsim as rs


def test_xarray_says_how_to_install_it(kept_run, without):
    without("xarray")
    with pytest.raises(ImportError, match=r"pip install 'roughsim\[xarray\]'"):
        kept_run.to_xarray()


def test_xarray_has_names_axes_and_units(kept_run):
    pytest.importorskip("xarray")
    data = kept_run.to_xarray()
    assert dict(data.flash_temperature.sizes) == {"level": 3, "realization": 3, "speed": 3}
    for name, unit in FLAT_UNITS.items():
        assert data[name].attrs["units"] == unit
    assert {"column", "q_max", "level", "speed", "realization"} <= set(data.coords)
    capped = data.where(data.column == "capped", drop=True).mean("realization")
    lowest, above = capped.flash_temperature
    # the values of the highest cut-off: the mean of the lowest level times the ratio of the one above to it
    highest = lowest * above / capped.flash_temperature_below[1]
    estimate = kept_run.estimate("flash_temperature")
    np.testing.assert_allclose(highest[1:], (estimate.mean + estimate.bias)[1:], rtol=1e-12)


def test_xarray_reads_fields_when_they_are_used(kept_run, calls):
    pytest.importorskip("xarray")
    from roughsim.results import run

    read = calls(run, "read_fields")
    data = kept_run.to_xarray()
    assert read == []
    corner = data.pressure_L2.sel(kept_realization_L2=1)[3:9, ::7].values
    assert [path.name for path, *_ in read] == ["L2-000001.h5"]
    fields = dict(kept_run.fields("pressure"))
    np.testing.assert_array_equal(corner, fields[1][3:9, ::7])
    np.testing.assert_array_equal(data.pressure_L2, [fields[0], fields[1]])
    np.testing.assert_array_equal(data.pressure_L2[::-1, 5], [fields[1][5], fields[0][5]])
    np.testing.assert_array_equal(data.pressure_L2[[1], [4, 2]], fields[1][None, [4, 2]])
    assert data.pressure_L2[:0, 3].shape == (0, 128)


def test_stress_spectra_are_those_of_the_files(kept_run):
    pytest.importorskip("xarray")
    data = kept_run.to_xarray()
    for level, index in ((0, 0), (1, 2), (2, 1)):
        member = read_member(kept_run.folder, level, index)
        np.testing.assert_array_equal(
            data[f"stress_spectrum_L{level}"][index], member.moments[0].spectrum
        )
        np.testing.assert_array_equal(data[f"wavenumber_L{level}"], member.moments[0].wavenumber)


@pytest.mark.parametrize("engine", some(["h5netcdf", "netcdf4"], 2))
def test_the_file_opens_in_xarray_with_the_numbers_of_the_run(kept_run, file, engine):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip({"netcdf4": "netCDF4"}.get(engine, engine))
    flat = kept_run.to_xarray()
    with xarray.open_dataset(
        file, engine=engine, group="members"
    ) as stored:  # warnings are errors here
        assert set(stored.variables) == set(flat.variables)
        for name in flat.variables:
            np.testing.assert_array_equal(stored[name], flat[name])
            assert stored[name].dims == flat[name].dims
    with xarray.open_datatree(file, engine=engine) as tree:
        capped = tree["results"].flash_temperature.sel(column="capped")
        np.testing.assert_array_equal(capped, kept_run.estimate("flash_temperature").mean)
        for name, unit in BOTH.items():
            assert tree[f"results/{name}"].attrs["units"] == unit


def test_levels_have_their_own_numbers_of_members_and_nan_beyond(whole):
    pytest.importorskip("xarray")
    data = whole.to_xarray()
    counts = np.array(whole.counts)
    assert data.sizes["realization"] == counts.max() > counts.min()
    for level, count in enumerate(counts):
        assert np.isfinite(data.contact_fraction[level]).values.tolist() == [
            i < count for i in range(counts.max())
        ]
        assert np.isfinite(data[f"stress_spectrum_L{level}"][:, 0]).sum() == count
        assert data.converged[level].sum() == count


def test_numbers_of_the_level_below_stand_beside_those_of_the_level(whole):
    pytest.importorskip("xarray")
    data = whole.to_xarray()
    assert np.isnan(data.flash_temperature_below[0]).all()  # nothing lies below the lowest level
    for index in range(whole.counts[1]):
        member = read_member(whole.folder, 1, index)
        for name, share in (("flash_temperature", 0.9), ("contact_fraction", 1.0)):
            values = data[f"{name}_below"][1, index]
            np.testing.assert_allclose(
                np.atleast_1d(values), member.moments[1].numbers[name] * share, rtol=1e-15
            )
        np.testing.assert_array_equal(
            data.stress_spectrum_below_L1[index], member.moments[1].spectrum
        )
        np.testing.assert_array_equal(data.wavenumber_below_L1, member.moments[1].wavenumber)
    assert data.flash_temperature_below.attrs["units"] == "K"


def test_a_failed_member_is_nan_and_counted(kept_run):
    xarray = pytest.importorskip("xarray")
    run = rs.open_run(kept_run.folder)
    run.members[1, 2] = replace(run.members[1, 2], failure="stalled", moments=())
    data = run.to_xarray()
    assert isinstance(data, xarray.Dataset)
    assert data.converged.values.tolist() == [[1, 1, 1], [1, 1, 0], [1, 1, 1]]
    assert np.isnan(data.flash_temperature[1, 2]).all()
    assert np.isnan(data.stress_spectrum_L1[2]).all()
    assert np.isfinite(data.flash_temperature).sum() == 8 * 3


def test_a_dataset_is_pickled_with_the_paths_of_its_fields_and_read_in_another_directory(
    kept_run, tmp_path
):
    pytest.importorskip("xarray")
    with contextlib.chdir(kept_run.folder.parent):
        data = rs.open_run(kept_run.folder.name).to_xarray()
        content = pickle.dumps(data)
    with contextlib.chdir(tmp_path):
        copy = pickle.loads(content)
        assert copy.identical(data)
        assert float(copy.pressure_L0[0].sum()) > 0.0


@pytest.mark.parametrize(
    "what", [lambda run: run, lambda run: run.estimate("flash_temperature"), rs.compare]
)
def test_runs_estimates_and_comparisons_are_pickled(kept_run, what):
    copy = pickle.loads(pickle.dumps(what(kept_run)))
    assert repr(type(copy)) == repr(type(what(kept_run)))
    if hasattr(copy, "estimate"):
        found, known = (run.estimate("flash_temperature") for run in (copy, kept_run))
        np.testing.assert_array_equal(found.mean, known.mean)
