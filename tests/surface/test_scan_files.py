"""Files of scans as programs write them: the same heights, size, unit and axes from each, or one sentence."""

import gzip
import io
import math
import warnings

import h5py
import numpy as np
import pytest
from scipy.io import netcdf_file

import roughsim as rs
from roughsim.scene.scans import read_scans
from roughsim.surface.topography.reading import Profile, read_scan
from roughsim.surface.topography.writing import encoded

SHAPE, SIZE = (40, 24), (80e-6, 48e-6)  # square pixels of 2 µm
X, Y = (2.0 * np.arange(n) for n in SHAPE)  # µm


@pytest.fixture(scope="module")
def heights():
    """A map in µm without mean and tilt, alike in no direction, so that a turned or mirrored one differs."""
    noise = np.random.default_rng(2).standard_normal(SHAPE)
    tilted = noise + 3.0 * np.outer(np.linspace(0, 1, 40) ** 3, np.linspace(1, 0, 24) ** 2)
    x, y = X - X.mean(), Y - Y.mean()
    level = tilted - tilted.mean()
    return (
        level
        - np.outer(x, np.ones(24)) * (level.mean(1) @ x / (x @ x))
        - y * (level.mean(0) @ y / (y @ y))
    )


def text(table, divider=" ", header="", comma=False):
    stream = io.StringIO()
    np.savetxt(stream, table, delimiter=divider, fmt="%.9g", header=header, comments="")
    return stream.getvalue().replace(".", ",") if comma else stream.getvalue()


def save(folder, name, content):
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    return folder / name


def quietly(path, **how):
    """Read a scan, which warns; return it and the warnings."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = read_scan(path, **how)
    return found, " ".join(str(one.message) for one in told)


def assert_is(found, heights, rtol=1e-6):
    assert found.grid.shape == SHAPE
    assert found.grid.lengths == pytest.approx(SIZE)
    np.testing.assert_allclose(found.heights, 1e-6 * heights, atol=rtol * 1e-6 * np.ptp(heights))


GIVEN = {"size": SIZE, "unit": 1e-6}
CORNER = np.zeros((1, 1))


@pytest.mark.parametrize(
    ("line", "column"),
    [(True, False), (False, True), (True, True)],
    ids=["first line", "first column", "both"],
)
@pytest.mark.parametrize(
    "of",
    [
        np.arange,
        lambda n: 2.0 * np.arange(n)[::-1],
        lambda n: np.round(1e-3 * (5.0 + 2.0 * np.arange(n)), 3),
        lambda n: np.round(1.5625 * np.arange(n)),
    ],
    ids=["counted", "coordinates that fall", "in mm", "rounded"],
)
def test_lines_that_count_are_no_heights(tmp_path, heights, line, column, of):
    table = 0.01 * heights if of(3)[1] > 1.8 and of(40)[1] == 2 else heights
    scale = 1.0 if table is heights else 0.01
    if line:
        table = np.vstack([of(24), table])
    if column:
        table = np.column_stack([np.concatenate([[0.0], of(40)]) if line else of(40), table])
    path = save(tmp_path, "a.csv", text(table, ","))
    found, told = quietly(path, size=SIZE, unit=1e-6 / scale)
    assert_is(found, heights)
    assert ("its first line, which counts in even steps" in told) == line
    assert ("its first column, which counts in even steps" in told) == column


def test_the_index_and_the_header_of_pandas_are_no_heights(tmp_path, heights):
    lines = ["," + ",".join(str(k) for k in range(24))]
    lines += [f"{i}," + ",".join(f"{h:.9g}" for h in row) for i, row in enumerate(heights)]
    found, told = quietly(save(tmp_path, "a.csv", "\n".join(lines)), **GIVEN)
    assert_is(found, heights)
    assert "left out" in told
    named = text(heights, ",", header=",".join(f"c{k}" for k in range(24)))
    found, told = quietly(save(tmp_path, "b.csv", named), **GIVEN)
    assert_is(found, heights)
    assert "names of columns" in told


@pytest.mark.parametrize("seed", range(5))
def test_no_line_of_a_real_map_is_left_out(tmp_path, seed):
    # tilted by far more than it is rough, stepped, rounded to whole numbers, and one plane but for a dent
    rng = np.random.default_rng(seed)
    rough = rng.standard_normal(SHAPE)
    smooth = np.cumsum(np.cumsum(rough, axis=0), axis=1)
    plane = np.add.outer(5.0 * np.arange(40), 70.0 * np.arange(24))
    dented = plane.copy()
    dented[20:30, 5:15] -= 300.0
    for table in (
        rough + 100.0 * plane,
        smooth,
        np.round(rough + plane),
        np.where(X[:, None] < 40, 0, 500) + rough,
        dented,
    ):
        found, told = quietly(save(tmp_path, "a.txt", text(table)), **GIVEN)
        assert (found.grid.shape, told) == (SHAPE, "")


@pytest.mark.parametrize("mark", [-9999.0, -32768.0, 1e30, 9.96921e36, 65535.0, -123456.0])
@pytest.mark.parametrize("scale", [1.0, 300.0], ids=["near one", "hundreds"])
def test_numbers_that_stand_for_undefined_points_are_no_heights(tmp_path, heights, mark, scale):
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    table = scale * heights
    table.flat[::101] = mark
    if mark == -123456.0 and scale > 1.0:
        mark = table.flat[::101] = -1e7  # a number of no program: it has to be far away
    found, told = quietly(save(tmp_path, "a.txt", text(table)), size=SIZE, unit=1e-6 / scale)
    assert f"heights of {mark:g}, which stand for undefined points" in told
    assert "undefined points, 1 %, were filled" in told
    present = np.ones(SHAPE, bool)
    present.flat[::101] = False
    difference = (found.heights - 1e-6 * heights)[present]
    assert np.ptp(difference) < 0.15e-6  # the plane of least squares changed a little


def test_a_few_deep_points_are_heights(tmp_path, heights):
    table = heights.copy()
    table.flat[[100, 300, 500]] = -70.0 * heights.std()
    found, told = quietly(save(tmp_path, "a.txt", text(table)), **GIVEN)
    assert told == ""
    assert found.heights.min() < -60e-6 * heights.std()


def gwyddion(heights, unit="m", factor=1e-6):
    header = f"# Channel: Height\n# Width: 80.00 µm\n# Height: 48.00 µm\n# Value units: {unit}"
    return text(factor * heights.T, "\t", header)


@pytest.mark.parametrize("name", ["a.txt", "a.asc", "a.csv", "a.dat", "a.npy", "a"])
def test_a_header_says_size_unit_and_axes_whatever_the_name(tmp_path, heights, name):
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    assert_is(read_scan(save(tmp_path, name, gwyddion(heights))), heights)
    assert_is(read_scan(save(tmp_path, name, gwyddion(heights, "nm", 1e3))), heights)
    assert_is(read_scan(save(tmp_path, name, gwyddion(heights).encode("utf-16"))), heights)
    decimal_commas = gwyddion(heights).replace(".", ",")
    assert_is(read_scan(save(tmp_path, name, decimal_commas)), heights)
    with pytest.raises(
        rs.RecordError,
        match="contains its size and unit; remove topography_size and topography_unit",
    ):
        read_scan(save(tmp_path, name, gwyddion(heights)), **GIVEN)


def test_a_header_of_points_alone_asks_for_size_and_unit(tmp_path, heights):
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    path = save(tmp_path, "a.txt", text(heights.T, " ", "h = 24\nw = 40"))
    with pytest.raises(
        rs.RecordError, match="lacks its size and unit; give topography_size and topography_u"
    ):
        read_scan(path)
    assert_is(read_scan(path, **GIVEN), heights)


@pytest.mark.parametrize("name", ["a.txt", "a.csv", "a.asc", "a.xyz", "a"])
def test_numbers_alone_are_the_same_map_whatever_the_name_and_the_divider(tmp_path, heights, name):
    commented = "# made by hand\n" + text(heights)
    quoted = '"' + text(heights, '","').replace("\n", '"\n"').rstrip('"')
    for content in (
        text(heights), text(heights, ","), text(heights, ", "), text(heights, ";"), text(heights, "\t"), commented,
        text(heights, ";", comma=True), text(heights, "\t", comma=True), text(heights, "  ", comma=True), quoted,
        text(heights, ",").replace("\n", ",\n"),
    ):  # fmt: skip
        assert_is(read_scan(save(tmp_path, name, content), **GIVEN), heights)
    with pytest.warns(
        RuntimeWarning, match="two sides of topography_size exchanged its pixels would be square"
    ):
        read_scan(save(tmp_path, name, text(heights)), size=SIZE[::-1], unit=1e-6)


def test_one_length_for_a_map_of_uneven_points_is_told(tmp_path, heights):
    save(tmp_path, "a.txt", text(heights[:, : heights.shape[1] // 2]))
    keys = {"topography": "a.txt", "topography_unit": "um"}
    for size, told in (("1 mm", True), (["1 mm", "1 mm"], False)):
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            list(read_scans([tmp_path / "a.txt"], keys | {"topography_size": size}))
        assert [("write both sides" in str(line.message)) for line in found] == [True] * told


@pytest.mark.parametrize(
    "heading",
    ["x y z", "x/px y/px z/raw", "x [px] y [px] z [raw]", "X (px)   Y (px)   Height (raw)"],
)
def test_names_of_columns_are_no_heights(tmp_path, heights, heading):
    x, y = np.indices(heights.shape)
    rows = np.column_stack([x.ravel(), y.ravel(), heights.ravel()])
    path = save(tmp_path, "a.xyz", heading + "\n" + text(rows))
    with pytest.warns(RuntimeWarning, match="left out: its first line, names of columns"):
        found = read_scan(path, **GIVEN)
    assert_is(found, heights)


def test_a_list_of_x_y_and_height_is_a_map(tmp_path, heights):
    listed = np.column_stack([np.repeat(X, 24), np.tile(Y, 40), heights.ravel()])
    shuffled = np.random.default_rng(1).permutation(listed)
    for table in (listed, shuffled, listed + np.array([5.0, -3.0, 0.0])):
        found, told = quietly(save(tmp_path, "a.xyz", text(table)), unit=1e-6)
        assert_is(found, heights)
        assert "coordinates have no unit" in told
    half = listed * [0.5, 0.5, 1.0]
    assert quietly(save(tmp_path, "a.xyz", text(half)), unit=1e-6)[0].grid.lengths == pytest.approx(
        (40e-6, 24e-6)
    )
    assert_is(
        read_scan(save(tmp_path, "a.xyz", text(half)), **GIVEN), heights
    )  # a size that is given counts


@pytest.mark.filterwarnings("ignore:.*coordinates have no unit:RuntimeWarning")
@pytest.mark.parametrize("kind", ["column", "line", "two columns", "falling", "npy"])
def test_a_line_scan_keeps_its_length_and_heights(tmp_path, kind):
    line = np.random.default_rng(3).standard_normal(100)
    x = np.arange(100) - 49.5
    level = line - line.mean()
    level -= x * (level @ x / (x @ x))
    table = {
        "column": line[:, None],
        "line": line[None],
        "two columns": np.column_stack([3.0 + 0.5 * np.arange(100), line]),
        "falling": np.column_stack([3.0 + 0.5 * np.arange(100), line])[::-1],
    }
    path = tmp_path / "a.npy"
    if kind == "npy":
        np.save(path, line)
    else:
        save(tmp_path, "a.npy", text(table[kind]))
    given = {"unit": 1e-6} | (
        {} if kind in ("two columns", "falling") else {"size": (50e-6, 50e-6)}
    )
    found, _ = quietly(path, **given)
    assert isinstance(found, Profile)
    assert found.length == pytest.approx(50e-6)
    np.testing.assert_allclose(found.heights, 1e-6 * level, atol=1e-14)
    if "size" in given:
        with pytest.raises(rs.RecordError, match="a line scan, which has one length"):
            read_scan(path, size=SIZE, unit=1e-6)


def as_netcdf(
    path,
    heights,
    *,
    classic,
    order="xy",
    units=("um", "um", "nm"),
    x=X,
    y=Y,
    packed=False,
    fill=None,
):
    data, axes = 1e3 * (heights if order == "xy" else heights.T), {"x": x, "y": y}
    attributes = {name: {"units": unit} for name, unit in zip("xyz", units, strict=True) if unit}
    own = attributes.setdefault("z", {})
    if packed:
        own["scale_factor"] = np.float64(0.5)
    if fill is not None:
        data.flat[:3] = own["_FillValue"] = np.float64(fill)
    write = classic_file if classic else hdf5_file
    write(path, order, axes, data, attributes)
    return path


def classic_file(path, order, axes, data, attributes):
    with netcdf_file(path, "w") as file:
        for name in order:
            file.createDimension(name, len(axes[name]))
            file.createVariable(name, "d", (name,))[:] = axes[name]
        file.createVariable("z", "d", tuple(order))[:] = data
        for name, own in attributes.items():
            for key, value in own.items():
                setattr(file.variables[name], key, value)


def hdf5_file(path, order, axes, data, attributes):
    with h5py.File(path, "w") as file:
        file["z"] = data
        for k, name in enumerate(order):
            file[name] = axes[name]
            file[name].make_scale(name)
            file["z"].dims[k].attach_scale(file[name])
        for name, own in attributes.items():
            file[name].attrs.update(own)


@pytest.mark.parametrize("classic", [True, False], ids=["netCDF-3", "netCDF-4"])
def test_netcdf_has_its_own_coordinates_and_units(tmp_path, heights, classic):
    how = {"classic": classic}
    assert_is(read_scan(as_netcdf(tmp_path / "a.nc", heights, **how)), heights)
    assert_is(read_scan(as_netcdf(tmp_path / "b.nc", heights, order="yx", **how)), heights)
    falling = as_netcdf(tmp_path / "c.nc", heights[:, ::-1], y=Y[::-1], **how)
    assert_is(read_scan(falling), heights)
    in_mm = as_netcdf(
        tmp_path / "d.nc", heights, x=1e-3 * X, y=1e-3 * Y, units=("mm", "mm", "nanometer"), **how
    )
    assert_is(read_scan(in_mm), heights)
    assert_is(read_scan(as_netcdf(tmp_path / "e.nc", 2 * heights, packed=True, **how)), heights)
    _, told = quietly(as_netcdf(tmp_path / "f.nc", heights, fill=-7.0, **how))
    assert "undefined points, 0.31 %" in told
    bare = as_netcdf(tmp_path / "g.nc", heights, units=("", "", ""), **how)
    with pytest.raises(rs.RecordError, match="lacks its unit; give topography_unit"):
        read_scan(bare)
    assert_is(read_scan(bare, size=SIZE, unit=1e-9), heights)
    np.testing.assert_allclose(quietly(bare, unit=1e-9)[0].grid.lengths, (80e-9, 48e-9))
    for units, message in (
        (("um", "mm", "nm"), "has x and y in different units"),
        (("um", "um", "K"), "has its z in 'K', which is no unit of length"),
    ):
        with pytest.raises(rs.RecordError, match=message):
            read_scan(as_netcdf(tmp_path / "h.nc", heights, units=units, **how))
    with pytest.raises(rs.RecordError, match="has its x at uneven steps"):
        read_scan(as_netcdf(tmp_path / "i.nc", heights, x=X**2, **how))


def test_xarray_writes_what_is_read(tmp_path, heights):
    xarray = pytest.importorskip("xarray", exc_type=ImportError)
    pytest.importorskip("h5netcdf", exc_type=ImportError)
    data = xarray.DataArray(
        1e3 * heights, dims=("x", "y"), coords={"x": X, "y": Y}, attrs={"units": "nm"}, name="h"
    )
    for axis in "xy":
        data[axis].attrs["units"] = "um"
    for engine in ("scipy", "h5netcdf"):
        data.to_netcdf(tmp_path / f"{engine}.nc", engine=engine)
        assert_is(read_scan(tmp_path / f"{engine}.nc"), heights)


def test_units_of_netcdf_4_may_have_letters_beyond_ascii(tmp_path, heights):
    path = as_netcdf(tmp_path / "a.nc", heights, classic=False, units=("", "", ""))
    with h5py.File(path, "r+") as file:  # as netCDF-4 stores them: an array of one string
        for name, unit in (("x", "µm"), ("y", "μm"), ("z", "nm")):
            file[name].attrs["units"] = np.array([unit], dtype=h5py.string_dtype())
    assert_is(read_scan(path), heights)


def test_hdf5_without_a_size_takes_it_from_the_keys(tmp_path, heights):
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["surface"] = heights
    with pytest.raises(rs.RecordError, match="give topography_size and topography_unit"):
        read_scan(tmp_path / "a.h5")
    assert_is(read_scan(tmp_path / "a.h5", **GIVEN), heights)
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file["amplitude"] = heights
    with pytest.raises(
        rs.RecordError,
        match="several sets of numbers without a unit, .*amplitude.*save the heights alone",
    ):
        read_scan(tmp_path / "a.h5", **GIVEN)


def test_a_packed_file_is_what_it_holds(tmp_path, heights):
    grid = rs.Grid(SHAPE, SIZE)
    content = encoded(1e-6 * heights, grid, ".nc")
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    np.testing.assert_allclose(
        read_scan(save(tmp_path, "a.nc.gz", gzip.compress(content))).heights, 1e-6 * heights
    )
    assert_is(read_scan(save(tmp_path, "b", gzip.compress(gwyddion(heights).encode()))), heights)


# a list takes ten times as long a try as the others
LISTED = [("list", 12), pytest.param("list", 60, marks=pytest.mark.slow)]


@pytest.mark.statistical
@pytest.mark.parametrize(
    ("kind", "tries"),
    [*((kind, 60) for kind in ("text", "gwyddion", "netCDF-3", "netCDF-4", "gz", "npy")), *LISTED],
)
def test_a_damaged_file_is_refused_or_the_map_that_it_was(tmp_path, heights, kind, tries):
    # cut anywhere: refused, or, of lines of numbers, fewer of them. No other error, and nothing takes long
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    listed = np.column_stack([np.repeat(X, 24), np.tile(Y, 40), heights.ravel()])
    if kind.startswith("netCDF"):
        content = as_netcdf(tmp_path / "whole", heights, classic=kind.endswith("3")).read_bytes()
    elif kind == "npy":
        np.save(tmp_path / "whole.npy", heights)
        content = (tmp_path / "whole.npy").read_bytes()
    else:
        texts = {
            "text": text(heights),
            "list": text(listed),
            "gwyddion": gwyddion(heights),
            "gz": gwyddion(heights),
        }
        content = texts[kind].encode()
        content = gzip.compress(content) if kind == "gz" else content
    given = {"text": GIVEN, "npy": GIVEN, "list": {"unit": 1e-6}}.get(kind, {})
    rng = np.random.default_rng(4)
    for k in range(tries):
        damaged = bytearray(content[: rng.integers(len(content))] if k % 2 else content)
        if not k % 2:
            damaged[rng.integers(min(len(damaged), 600 if k % 4 else len(damaged)))] ^= (
                1 << rng.integers(8)
            )
        try:
            found, _ = quietly(save(tmp_path, "a", bytes(damaged)), **given)
        except rs.RecordError:
            continue
        assert np.isfinite(found.heights).all()
        assert math.isfinite(np.ptp(found.heights))


@pytest.mark.parametrize("line", [0, 1, 23])
def test_a_damaged_line_of_numbers_is_named_and_not_skipped(tmp_path, heights, line):
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    commas = text(heights.T, ";", comma=True)
    for content, given in (
        (gwyddion(heights), {}), (text(heights.T, ","), GIVEN), (text(heights.T), GIVEN), (commas, GIVEN),
    ):  # fmt: skip
        lines = content.splitlines()
        k = line + (4 if not given else 0)
        lines[k] = lines[k].replace("," if content is commas else ".", "x", 1)
        with pytest.raises(
            rs.RecordError, match="x.* in a line of numbers; it is damaged|line .* has '.*x"
        ):
            read_scan(save(tmp_path, "a.txt", "\n".join(lines)), **given)
