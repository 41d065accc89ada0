"""Every file opens in the readers of the trade, with names, axes, units and a default plot, and without a warning."""

import logging
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from stored_cases import member_path, write_member

import roughsim as rs
from roughsim.results.export import export_run
from roughsim.store.member_files import fields_path

# warnings are errors in all tests, so each of these also says that the reader has nothing to complain about
UNITS = {
    "flash_temperature": "K",
    "flash_laplacian": "K/m^2",
    "contact_fraction": "1",
    "pressure_variance": "Pa^2",
}
FIELDS = {"x": "m", "y": "m", "heights": "m", "pressure": "Pa"}
MEMBERS = {"L2/speed": "m/s", "L2/wavenumber": "1/m", "L2/stress_spectrum": "Pa^2"}
EXPORT = {f"results/{name}": unit for name, unit in UNITS.items()} | {
    "results/speed": "m/s", "members/x_L2": "m", "members/pressure_L2": "Pa"
}  # fmt: skip
AXES = {
    "L2/numbers": ("realization", "below", "number", "speed"), "L2/unit": ("number",),
    "L2/stress_spectrum": ("realization", "below", "wavenumber"), "L2/about": ("realization",),
}  # fmt: skip
EXPORT_AXES = {
    "results/flash_temperature": ("column", "speed"), "results/contact_fraction_total_error": ("column",),
    "results/flash_temperature_part": ("part", "column", "speed"), "results/flash_temperature_note": ("column", "speed"),
    "members/flash_temperature": ("level", "realization", "speed"), "members/cell": ("level",),
    "members/stress_spectrum_L2": ("realization", "wavenumber_L2"),
    "members/pressure_L2": ("kept_realization_L2", "x_L2", "y_L2"),
    "members/temperature_L2": ("kept_realization_L2", "x_L2", "y_L2"),
}  # fmt: skip
WANTED = {
    "fields": (FIELDS, {"pressure": ("x", "y")}),
    "members": (MEMBERS, AXES),
    "failed": ({}, {"L0/about": ("realization",)}),
    "export": (EXPORT, EXPORT_AXES),
}
ROOT = Path(__file__).parents[2]
DRAWN = ("fields", "export", "export without fields")  # what viewers draw something of
CASES = (*DRAWN, "members", "failed member")


@pytest.fixture(scope="module")
def kept_run(capped_scene, tmp_path_factory):
    """Two realizations, the fields of one kept."""
    scene = replace(capped_scene, numerics=replace(capped_scene.numerics, keep_fields=1))
    return rs.run(scene, tmp_path_factory.mktemp("readers") / "kept", max_realizations=2)


@pytest.fixture(scope="module")
def files(kept_run, capped_scene, tmp_path_factory):
    """One file of each kind."""
    from roughsim.observables.member import Member

    place = tmp_path_factory.mktemp("files")
    bare = replace(capped_scene, numerics=replace(capped_scene.numerics, keep_fields=0))
    (place / "members").mkdir()
    write_member(place, Member(0, 0, failure="stalled"))
    other = rs.run(bare, place / "bare", max_realizations=1)
    return {
        "fields": fields_path(kept_run.folder, 2, 0),
        "members": kept_run.folder / "members.h5",
        "export": export_run(kept_run, place / "kept.h5"),
        "export without fields": export_run(other, place / "bare.nc"),
        "failed member": member_path(place, 0, 0),
    }


@pytest.fixture(autouse=True)
def nothing_logged(caplog):
    """silx and nexusformat log where others warn."""
    yield
    assert [
        record.getMessage() for record in caplog.records if record.levelno >= logging.WARNING
    ] == []


def expected(case):
    """Units and axes that a reader has to find in a file."""
    units, axes = WANTED[case.split()[0]]
    if "without fields" in case:
        gone = re.compile(r"(members/)?(x|y|heights|pressure|temperature)(_L2)?")
        units, axes = ({k: v for k, v in d.items() if not gone.fullmatch(k)} for d in (units, axes))
    return units, axes


@pytest.mark.parametrize("case", CASES)
@pytest.mark.slow
def test_xarray_finds_names_axes_and_units(files, case):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    units, axes = expected(case)
    with xarray.open_dataset(files[case], engine="h5netcdf") as data:
        data.load()
    with xarray.open_datatree(files[case], engine="h5netcdf") as tree:
        assert {name: tree[name].attrs["units"] for name in units} == units
        assert {name: tree[name].dims for name in axes} == axes
        assert tree.attrs.get("default") == ("entry" if case in DRAWN else None)
        tree.load()


@pytest.mark.parametrize("case", CASES)
def test_netcdf4_finds_names_axes_and_units(files, case):
    netcdf = pytest.importorskip("netCDF4")
    units, axes = expected(case)
    with netcdf.Dataset(files[case]) as data:
        assert {name: data[name].units for name in units} == units
        assert {name: data[name].dimensions for name in axes} == axes
        for variable in data.variables.values():
            assert np.shape(variable[...]) == variable.shape


@pytest.mark.parametrize("case", DRAWN)
def test_silx_draws_the_default_plot_with_its_units(files, case):
    silx = pytest.importorskip("silx.io")
    nxdata = pytest.importorskip("silx.io.nxdata")
    with silx.open(str(files[case])) as file:
        shown = nxdata.get_default(file)
        assert shown.is_valid
        assert not shown.issues
        name, axes, labels = DEFAULTS[case]
        assert shown.signal_name == name
        assert tuple(shown.axes_dataset_names) == axes
        assert tuple(shown.axes_names) == labels  # silx writes the units behind


@pytest.mark.parametrize("case", DRAWN)
def test_nexusformat_finds_the_default_plot(files, case):
    nexus = pytest.importorskip("nexusformat.nexus")
    tree = nexus.nxload(str(files[case]))
    shown = tree.get_default()
    assert isinstance(shown, nexus.NXdata)
    name, axes, _ = DEFAULTS[case]
    assert shown.nxsignal.nxname == name.partition(" ")[0]
    assert tuple(axis.nxname for axis in shown.nxaxes) == axes
    assert shown.nxsignal.attrs["units"] in ("Pa", "Pa^2", "K")
    assert all("units" in axis.attrs for axis in shown.nxaxes)
    assert np.isfinite(shown.nxsignal.nxdata).all()


# signal, its axes, and how silx labels them
DEFAULTS = {
    "fields": ("pressure (Pa)", ("x", "y"), ("x (m)", "y (m)")),
    "export": ("capped (K)", ("speed",), ("speed (m/s)",)),
    "export without fields": ("capped (K)", ("speed",), ("speed (m/s)",)),
}  # fmt: skip


@pytest.mark.parametrize("case", ["fields", "export"])
def test_every_group_that_viewers_draw_is_a_valid_one(files, case):
    silx = pytest.importorskip("silx.io")
    nxdata = pytest.importorskip("silx.io.nxdata")
    with silx.open(str(files[case])) as file:
        for group in file["entry"].values():
            found = nxdata.NXdata(group)
            assert found.is_valid, group.name
            assert not found.issues


@pytest.mark.parametrize(("engine", "as_text"), [("h5netcdf", str.encode), ("netcdf4", str)])
def test_stored_numbers_are_found_by_their_names(kept_run, files, engine, as_text):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf" if engine == "h5netcdf" else "netCDF4")
    with xarray.open_dataset(files["members"], engine=engine, group="L2") as data:
        for index in (0, 1):
            one = kept_run.members[2, index]
            for name, unit in UNITS.items():
                assert data.unit.sel(number=as_text(name)) == as_text(unit)
                for below, numbers in enumerate(part.numbers for part in one.moments):
                    place = {"number": as_text(name), "below": below, "realization": index}
                    found = data.numbers.sel(place)
                    np.testing.assert_array_equal(found[: len(numbers[name])], numbers[name])
        np.testing.assert_array_equal(data.speed, kept_run.scene.speeds)
    with xarray.open_dataset(files["fields"], engine=engine) as data:
        assert float(data.pressure.mean()) == pytest.approx(
            90e6, rel=1e-4
        )  # force balance, solver tolerance 1e-4


def test_the_examples_of_the_page_on_files_run(kept_run, tmp_path, in_tmp_path):
    for name in ("xarray", "h5netcdf", "netCDF4", "nexusformat.nexus"):
        pytest.importorskip(name)
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "steel").symlink_to(kept_run.folder)
    blocks = re.findall(
        r"```python\n(.*?)```", (ROOT / "docs" / "files.md").read_text(encoding="utf-8"), re.DOTALL
    )
    assert len(blocks) == 4
    names = {}
    for block in blocks:
        exec(block, names)
    assert {path.name for path in tmp_path.iterdir()} == {"runs", "steel.h5"}
