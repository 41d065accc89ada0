"""Files with several channels of heights, and units in the headings of lists: what is taken, and what is said of it."""

import struct
import warnings

import h5py
import numpy as np
import pytest

import roughsim as rs
from roughsim.cli import main
from roughsim.prediction.statements import statements
from roughsim.scene import parse_scene
from roughsim.surface.topography.measured import levelled
from roughsim.surface.topography.reading import Profile, read_scan

SIZE = 20e-6
HEIGHTS = np.random.default_rng(1).standard_normal((20, 24)) * 1e-7
RMS = float(np.std(levelled(HEIGHTS)))
BODY = """
[body]
youngs_modulus = "200 GPa"
poisson_ratio = 0.3
conductivity = 30
density = 7900
heat_capacity = 500
[sliding]
nominal_pressure = "5 MPa"
friction_coefficient = 0.11
speed = "1 m/s"
"""


def component(name, kind, content):
    return name.encode() + b"\0" + kind + content


def gwy_object(name, *components):
    content = b"".join(components)
    return name.encode() + b"\0" + struct.pack("<I", len(content)) + content


def gwy(path, **channels):
    """Write channels, name=(heights, unit), as Gwyddion does (see its documentation of the file format)."""
    whole = []
    for number, (name, (values, unit)) in enumerate(channels.items()):
        field = [
            component("xres", b"i", struct.pack("<i", values.shape[0])),
            component("yres", b"i", struct.pack("<i", values.shape[1])),
            component("xreal", b"d", struct.pack("<d", SIZE)),
            component("yreal", b"d", struct.pack("<d", SIZE)),
        ]
        for axis, name_of_unit in (("xy", "m"), ("z", unit)):
            text = component("unitstr", b"s", name_of_unit.encode() + b"\0")
            field.append(component(f"si_unit_{axis}", b"o", gwy_object("GwySIUnit", text)))
        data = values.T.astype("<f8").tobytes()
        field.append(component("data", b"D", struct.pack("<I", values.size) + data))
        whole.append(component(f"/{number}/data", b"o", gwy_object("GwyDataField", *field)))
        whole.append(component(f"/{number}/data/title", b"s", name.encode() + b"\0"))
    path.write_bytes(b"GWYP" + gwy_object("GwyContainer", *whole))
    return path


def quietly(path, **how):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = read_scan(path, **how)
    return found, " ".join(str(one.message) for one in told)


TWICE = {"Phase": (1e7 * HEIGHTS, "deg"), "Retrace": (2 * HEIGHTS, "m"), "Height": (HEIGHTS, "m")}


@pytest.fixture(autouse=True)
def library():
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)


def test_the_channel_of_several_is_named_and_chosen(tmp_path):
    path = gwy(tmp_path / "a.gwy", **TWICE)
    found, told = quietly(path)
    assert np.std(found.heights) == pytest.approx(2 * RMS)
    assert (
        "the channel 'Retrace' is taken; topography_channel chooses another one: 1 'Retrace', 2 'Height'"
        in told
    )
    assert found.taken == "channel 'Retrace', heights in m, sides in m"
    for channel, factor in (("Height", 1), ("height", 1), (2, 1), ("Retrace", 2), (1, 2)):
        found, told = quietly(path, channel=channel)
        assert np.std(found.heights) == pytest.approx(factor * RMS)
        assert told == ""
    for channel in ("Heigth", 0, 3, -1, "Phase"):
        with pytest.raises(
            rs.RecordError,
            match="has no channel of heights .*; the choice is 1 'Retrace', 2 'Height'",
        ):
            read_scan(path, channel=channel)


def test_a_current_is_no_height_in_angstroms(tmp_path):
    found, told = quietly(gwy(tmp_path / "a.gwy", Current=(HEIGHTS, "A"), Height=(HEIGHTS, "m")))
    assert np.std(found.heights) == pytest.approx(RMS)
    assert told == ""


def test_one_height_among_other_channels_needs_no_word(tmp_path):
    found, told = quietly(gwy(tmp_path / "a.gwy", Phase=TWICE["Phase"], Height=TWICE["Height"]))
    assert np.std(found.heights) == pytest.approx(RMS)
    assert told == ""
    assert "channel 'Height'" in found.taken


def test_a_file_without_heights_lists_its_channels(tmp_path):
    path = gwy(tmp_path / "a.gwy", Phase=(HEIGHTS, "deg"), Current=(HEIGHTS, "A"))
    with pytest.raises(
        rs.RecordError, match="holds no channel of heights, only 'Phase', 'Current'; save"
    ):
        read_scan(path)
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["stack"] = np.zeros((3, 9, 9))
        file["of/one"] = np.zeros(5)
    with pytest.raises(
        rs.RecordError,
        match=r"holds no map, but of/one of shape \(5,\), stack of shape \(3, 9, 9\)",
    ):
        read_scan(tmp_path / "b.h5")


def test_channels_of_one_name_are_chosen_by_number(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["Height"], file["height"] = HEIGHTS, 2 * HEIGHTS
    given = {"size": (SIZE, SIZE), "unit": 1.0}
    with pytest.raises(
        rs.RecordError,
        match="has several channels of heights with the name 'height'; the choice is 1",
    ):
        read_scan(tmp_path / "a.h5", channel="height", **given)
    with pytest.raises(
        rs.RecordError,
        match="several sets of numbers without a unit, 1 'Height', 2 'height'; write",
    ):
        read_scan(tmp_path / "a.h5", **given)
    assert np.std(read_scan(tmp_path / "a.h5", channel=2, **given).heights) == pytest.approx(
        2 * RMS
    )


def test_variables_of_netcdf_are_channels(tmp_path):
    with h5py.File(tmp_path / "a.nc", "w") as file:
        for name, points in (("x", 20), ("y", 24)):
            file[name] = 1e-6 * np.arange(points)
            file[name].attrs["units"] = "m"
            file[name].make_scale(name)
        for name, factor in (("trace", 1), ("retrace", 2)):
            file[name] = factor * HEIGHTS
            file[name].attrs["units"] = "m"
            for axis in range(2):
                file[name].dims[axis].attach_scale(file["xy"[axis]])
    with pytest.raises(
        rs.RecordError, match="holds several sets of numbers, .*; write the name of one as"
    ):
        read_scan(tmp_path / "a.nc")
    assert np.std(read_scan(tmp_path / "a.nc", channel="retrace").heights) == pytest.approx(2 * RMS)


def test_a_scene_keeps_the_channel_of_its_scan(tmp_path, capsys):
    gwy(tmp_path / "a.gwy", **TWICE)
    text = f'[surface]\ntopography = "a.gwy"\ntopography_channel = "Height"{BODY}'
    scene = parse_scene(text, folder=tmp_path)
    assert scene.surface.psd_scans == ("a.gwy: channel 'Height', heights in m, sides in m",)
    assert parse_scene(scene.to_toml()) == scene
    assert not any("psd_scans" in key for key in scene.identity())
    assert "scan of [surface]: a.gwy: channel 'Height', heights in m, sides in m" in " ".join(
        map(str, statements(scene))
    )
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(SystemExit):
        main(["plan", str(tmp_path / "a.toml"), "--all"])
    assert "channel 'Height'" in capsys.readouterr().out


# --- units of lists


def listed(folder, heading, x_factor, z_factor):
    """Points of a map with sides of 20 × 24 µm, in units of so many metres."""
    x, y = np.indices(HEIGHTS.shape) * 1e-6 / x_factor
    rows = np.column_stack([x.ravel(), y.ravel(), HEIGHTS.ravel() / z_factor])
    np.savetxt(folder / "a.csv", rows, delimiter=";", header=heading, comments="")
    return folder / "a.csv"


@pytest.mark.parametrize(
    "heading",
    ["x/mm;y/mm;z/nm", "x [mm];y [mm];z [nm]", "X (mm);Y (mm);Height (nm)", "x_mm;y_mm;z_nm", "x;y;z\nmm;mm;nm",
     "# x/mm;y/mm;z/nm", "pos x mm;pos y mm;Z nm", '"x (mm, abs)";"y/mm";"z [nm, raw]"'],
)  # fmt: skip
def test_units_of_a_heading_are_read(tmp_path, heading):
    path = listed(tmp_path, heading, 1e-3, 1e-9)
    for unit in (None, 1e-9):  # a key that agrees is no fault
        found, told = quietly(path, unit=unit)
        assert found.grid.lengths == pytest.approx((20e-6, 24e-6))
        assert np.std(found.heights) == pytest.approx(RMS)
        assert found.taken == "heights in nm, sides in mm"
        assert "have no unit" not in told
    with pytest.raises(rs.RecordError, match="contains its unit; remove topography_unit"):
        read_scan(path, unit=1e-6)
    with pytest.raises(rs.RecordError, match="contains its size; remove topography_size"):
        read_scan(path, size=(1e-3, 1e-3))


def test_x_and_y_may_have_different_units(tmp_path):
    path = listed(tmp_path, "x/mm;y/cm;z/nm", 1e-3, 1e-9)
    assert quietly(path)[0].grid.lengths == pytest.approx((20e-6, 240e-6))


@pytest.mark.parametrize("divider", ["\t", " ", ","])
@pytest.mark.parametrize("units", ["mm mm nm", "[mm] [mm] [nm]", "(mm) (mm) (nm)"])
def test_units_may_stand_below_the_names(tmp_path, divider, units):
    path = listed(tmp_path, f"x;y;z\n{units.replace(' ', ';')}", 1e-3, 1e-9)
    path.write_text(path.read_text().replace(";", divider))
    found, _ = quietly(path)
    assert found.grid.lengths == pytest.approx((20e-6, 24e-6))
    assert np.std(found.heights) == pytest.approx(RMS)


def test_units_of_coordinates_or_heights_alone(tmp_path):
    path = listed(tmp_path, "x/mm;y/mm;z", 1e-3, 1e-9)
    with pytest.raises(rs.RecordError, match="lacks its unit; give topography_unit"):
        read_scan(path)
    assert quietly(path, unit=1e-9)[0].grid.lengths == pytest.approx((20e-6, 24e-6))
    path = listed(tmp_path, "x;y;z/nm", 1e-3, 1e-9)
    with pytest.raises(rs.RecordError, match="lacks its size; give topography_size"):
        read_scan(path)
    with pytest.raises(rs.RecordError, match="a unit of x or of y in its heading, but not of both"):
        read_scan(listed(tmp_path, "x/mm;y;z/nm", 1e-3, 1e-9))


@pytest.mark.parametrize("name", ["x [inch]", "x/in", "x (1e-3 m)", "x (in mm)"])
def test_a_unit_that_is_not_known_is_no_missing_one(tmp_path, name):
    with pytest.raises(rs.RecordError, match="has a unit that is not known in its heading, 'x/"):
        read_scan(listed(tmp_path, f"{name};y;z", 1e-3, 1e-9), unit=1e-9)


def test_coordinates_without_a_unit_are_said_to_be_taken(tmp_path):
    found, told = quietly(listed(tmp_path, "x;y;z", 1e-6, 1e-6), unit=1e-6)
    assert found.grid.lengths == pytest.approx((20e-6, 24e-6))
    assert (
        "coordinates have no unit, and are taken in um as the heights; if it is another one" in told
    )
    assert found.taken == "heights in um by topography_unit, sides in the unit of the heights"
    given, told = quietly(listed(tmp_path, "x;y;z", 1e-3, 1e-6), unit=1e-6, size=(20e-6, 24e-6))
    assert given.grid.lengths == pytest.approx((20e-6, 24e-6))
    assert "have no unit" not in told


def test_a_stylus_line_has_units_of_its_own(tmp_path):
    line = np.random.default_rng(2).standard_normal(200)
    x = 0.5e-3 * np.arange(200)  # mm
    np.savetxt(
        tmp_path / "a.txt",
        np.column_stack([x, line]),
        header="Distance [mm]\tProfile [um]",
        comments="",
        delimiter="\t",
    )
    found, _ = quietly(tmp_path / "a.txt")
    assert isinstance(found, Profile)
    assert found.length == pytest.approx(100e-6)
    assert np.std(found.heights) == pytest.approx(1e-6 * np.std(levelled(line)))
    np.savetxt(tmp_path / "b.txt", line, header="Height (nm)", comments="")
    assert np.std(quietly(tmp_path / "b.txt", size=(1e-4, 1e-4))[0].heights) < 2e-9


def test_a_cut_ends_the_spectrum_of_a_scan(tmp_path):
    gwy(tmp_path / "a.gwy", Height=(HEIGHTS, "m"))
    text = f'[surface]\ntopography = "a.gwy"{BODY}'
    whole = parse_scene(text, folder=tmp_path).spectrum
    for cut in ('"1.5e6 1/m"', "1.5e6", f'"{2 * np.pi / 1.5e6} m"', f'"{2e6 * np.pi / 1.5e6} um"'):
        short = parse_scene(
            text.replace("[body]", f"topography_cut = {cut}\n[body]"), folder=tmp_path
        ).spectrum
        assert 0.85 * 1.5e6 < short.q[-1] < 1.5e6 * (1 + 1e-9)
        inside = short.q[short.q < 1e6]
        np.testing.assert_allclose(short(inside), whole(inside), rtol=1e-9)


# --- HDF5 with coordinates of its own


def test_hdf5_with_x_y_and_units_needs_no_keys(tmp_path):
    x, y = 1e-3 * np.arange(20), 1e-3 * np.arange(24)  # mm

    def save(name, heights, **units):
        with h5py.File(tmp_path / name, "w") as file:
            file["x"], file["y"], file["z"] = x, y, heights
            for key, unit in units.items():
                if key == "whole":
                    file.attrs["units"] = unit
                else:
                    file[key].attrs["units"] = unit
        return tmp_path / name

    each = {"x": "mm", "y": "mm", "z": "nm"}
    for found in (
        read_scan(save("a.h5", 1e9 * HEIGHTS, **each)),
        read_scan(save("b.h5", 1e9 * HEIGHTS.T, **each)),
        read_scan(save("c.h5", 1e3 * HEIGHTS, whole="mm")),
        read_scan(save("d.h5", 1e9 * HEIGHTS, whole="mm", z="nm")),
    ):
        assert found.grid.lengths == pytest.approx((20e-6, 24e-6))
        np.testing.assert_allclose(found.heights, levelled(HEIGHTS), atol=1e-15)
    with pytest.raises(rs.RecordError, match="lacks its unit; give topography_unit"):
        read_scan(save("e.h5", HEIGHTS))
    with h5py.File(tmp_path / "c.h5", "r+") as file:
        del file.attrs["units"]
        file["units"] = "mm"
    assert np.std(read_scan(tmp_path / "c.h5").heights) == pytest.approx(RMS)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_a_tiff_of_floating_point_numbers_is_a_map(tmp_path, kind):
    tifffile = pytest.importorskip("tifffile")
    given = {"size": (20e-6, 24e-6), "unit": 1e-9}
    tifffile.imwrite(tmp_path / "a.tif", (1e9 * HEIGHTS.T).astype(kind))  # a line is along x
    with pytest.raises(
        rs.RecordError, match="lacks its size and unit; give topography_size and topography_unit"
    ):
        read_scan(tmp_path / "a.tif")
    found, told = quietly(tmp_path / "a.tif", **given)
    np.testing.assert_allclose(found.heights, levelled(HEIGHTS), atol=1e-13)
    assert told == ""
    pages = np.stack([2e9 * HEIGHTS.T, 1e9 * HEIGHTS.T]).astype(kind)
    tifffile.imwrite(tmp_path / "b.tif", pages, photometric="minisblack")
    found, told = quietly(tmp_path / "b.tif", **given)
    assert np.std(found.heights) == pytest.approx(2 * RMS)
    assert "the channel 'page 1' is taken" in told
    assert np.std(read_scan(tmp_path / "b.tif", channel=2, **given).heights) == pytest.approx(RMS)
    tifffile.imwrite(
        tmp_path / "big.tif", (1e9 * HEIGHTS.T).astype(kind), bigtiff=True, byteorder=">"
    )
    assert np.std(read_scan(tmp_path / "big.tif", **given).heights) == pytest.approx(RMS)
    tifffile.imwrite(tmp_path / "c.tif", np.zeros((20, 24), np.uint8))
    with pytest.raises(
        rs.RecordError, match=r"is a picture \(TIFF\) without floating-point numbers"
    ):
        read_scan(tmp_path / "c.tif", **given)
