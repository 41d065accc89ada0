"""Scans: files that are no map, and keys that do not fit, are refused in one sentence that names the file."""

import gzip
import io
import zipfile

import h5py
import numpy as np
import pytest
from refused_cases import assert_refused

import roughsim as rs
from roughsim.results.export import export_surface
from roughsim.scene import load_scene
from roughsim.surface.topography.reading import read_scan
from roughsim.surface.topography.writing import encoded

SIDE = 1e-3
GIVEN = {"size": (SIDE, SIDE), "unit": 1e-6}
MAP = np.random.default_rng(3).standard_normal((64, 48))
GRID = rs.Grid(MAP.shape, (64e-6, 48e-6))


def text(table, divider=" "):
    stream = io.StringIO()
    np.savetxt(stream, table, delimiter=divider, fmt="%.9g")
    return stream.getvalue().encode()


def numpy_file(array):
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


def declared(shape):
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header


def container(*names):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as file:
        for name in names:
            file.writestr(zipfile.ZipInfo(name), b"CDF\x01 or so")
    return stream.getvalue()


NETCDF = encoded(1e-6 * MAP, GRID, ".nc")
LISTED = np.column_stack([*(k.ravel() for k in np.indices(MAP.shape)), MAP.ravel()])
NO_SCAN = {  # with and without size and unit
    "one.zip": (container("meta.yml", "a.nc"), r"is a container of 1 file; unpack it and name its scans \(a.nc\)"),
    "four.zip": (container("a.nc", "b.nc", "c.nc", "d.nc"), r"is a container of 4 files.*\(a.nc, b.nc, c.nc …\)"),
    "text.zip": (container("a.txt", "b.csv"), r"is a container of 2 files; unpack.*\(a.txt, b.csv\)"),
    "none.zip": (container("meta.yml"), "is a container without a scan"),
    "lfs.x3p": (b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 12\n", "is a pointer of Git LFS"),
    "cut.sur": (b"DIGITAL SURF" + bytes(range(256)) * 2, "begins as Digital Surf.*cut short or damaged"),
    "cut.x3p": (container("a.nc")[:60], "is a zip that is cut short or damaged"),
    "photo.png": (b"\x89PNG\r\n\x1a\n" + bytes(500), r"is a picture \(PNG\)"),
    "photo.tif": (b"II*\x00" + bytes(500), r"is a picture \(TIFF\)"),
    "page.x3p": (b"<!DOCTYPE html><html>login</html>", "is a document or a page of the web"),
    "scan.tar": (bytes(257) + b"ustar" + bytes(250), r"is packed \(tar\)"),
    "scan.7z": (b"7z\xbc\xaf\x27\x1c" + bytes(100), r"is packed \(7z\)"),
    "any.bin": (bytes(range(1, 256)) * 9, "has no format that is known; save it as x3p or nc"),
    "terrain.bin": (np.arange(64**2, dtype=">i2").tobytes(), "has no format that is known"),
    "twice.gz": (gzip.compress(gzip.compress(NETCDF)), "is packed twice"),
    "short.gz": (gzip.compress(NETCDF)[:-500], "packed by gzip and cut short or damaged"),
    "not.gz": (gzip.compress(NETCDF)[:50] + bytes(500), "packed by gzip and cut short or damaged"),
    "empty.sur": (b"", "is empty"),
}  # fmt: skip
NO_HEIGHTS = {  # with size and unit
    "words.txt": (b"a height map\n1 2\n", "must hold numbers alone, but line 1 is 'a height map'"),
    "uneven.csv": (b"1,2,3\n4,5\n", "as many numbers in each line: line 1 has 3, line 2 has 2"),
    "comma.csv": (b"\n".join(b"%d,%d" % (k, k % 7) for k in range(100)), "one number with a decimal comma, or two;"),
    "empty.txt": (b"", "is empty"),
    "comment.txt": (b"# nothing\n", "holds no numbers"),
    "binary.csv": (bytes(range(256)), "has no format that is known"),
    "empty.npy": (b"", "is empty"),
    "cut.npy": (b"\x93NUMPY\x01\x00v\x00", "cannot be read as heights"),
    "few.txt": (b"1 2 3 4 5 6 7 8 9\n", r"has \(9,\) points; C\(q\) needs at least 64 of a line scan"),
    "flat.txt": (b"1 1 1 1 1 1 1 1\n" * 8, "all alike"),
    "narrow.npy": (numpy_file(MAP[:4]), "at least 8 along each side"),
    "nan.txt": (b"nan nan nan nan nan nan nan nan\n" * 8, "100 % of its points are undefined"),
    "stack.npy": (numpy_file(MAP[None]), "holds numbers of shape .*; .* needs a map or a line scan"),
    "complex.npy": (numpy_file(MAP + 1j), "dtype complex128; heights must be real"),
    "letter.npy": (numpy_file(np.array([["a"]])), "dtype <U1"),
    "object.npy": (numpy_file(np.array([[{}]])), "pickled Python objects"),
    "vast.npy": (declared((4000000, 4000000)), r"(declares 1.6e\+13 points|cannot be read)"),
}  # fmt: skip
NO_KEYS = {  # without size or unit
    "bare.npy": (numpy_file(MAP), {}, "lacks its size and unit; give topography_size and topography_unit"),
    "bare.txt": (text(MAP), {}, "lacks its size and unit"),
    "twice.xyz": (text(np.vstack([LISTED, LISTED[:1]])), {"unit": 1e-6}, "lists a point twice"),
    "random.xyz": (text(np.random.default_rng(1).random((500, 3))), {"unit": 1e-6},
                   "at uneven steps; put its heights on even steps first"),
}  # fmt: skip
SIZED = '\ntopography_size = ["100 um", "75 um"]\ntopography_unit = "um"'
SCENES = {
    "give topography_size and topography_unit": 'topography = "a.npy"',
    "lacks its unit; give topography_unit": 'topography = "a.npy"\ntopography_size = "1 mm"',
    r"topography_size\[0\] = 0 m must be greater than 0 m": SIZED.replace('["100 um", "75 um"]', "0"),
    "topography_size.*has the dimension": SIZED.replace('"75 um"', '"1 K"'),
    "one number or two": SIZED.replace('"75 um"', "1e-3, 1e-3"),
    "for 1 files": SIZED.replace('["100 um", "75 um"]', "[[1e-3, 1e-3], [1e-3, 1e-3]]"),
    "topography_unit.*has the dimension": SIZED.replace('"um"', '"K"'),
    "must be a unit of length": SIZED.replace('"um"', "1e-6"),
    "must be the path of a file, for example": "topography = 7",
    "must be the path of a file": "topography = []",
    "topography = .*must be the path of a file": 'topography = ["a.npy", 3]',
    "names a file twice": 'topography = ["a.npy", "a.npy"]',
    "a.nc does not exist; check the path": 'topography = "a.nc"\ntopography_unit = "um"',
    "topography_unit goes with topography only": 'rms_height = 1e-6\ntopography_unit = "um"',
    r"rms_height does not go with surface.topography, whose map fixes C\(q\)": "rms_height = 1e-7" + SIZED,
    "psd_file does not go with surface.topography": 'psd_file = "a.csv"' + SIZED,
    "psd_convention does not go with surface.topography": 'psd_convention = "persson"' + SIZED,
    'did you mean "topography"': 'topografy = "a.npy"',
    "topography_cut.*has the dimension": 'topography_cut = "3 K"' + SIZED,
    "topography_cut = -1.*greater than 0": "topography_cut = -1" + SIZED,
    "topography_cut.*has no unit": 'topography_cut = "2.5"' + SIZED,
    "all cut by.*topography_cut|topography_cut.*all cut by": 'topography_cut = "1e9 m"' + SIZED,
    "has no channels to choose from; remove topography_channel": 'topography_channel = "Height"' + SIZED,
    "topography_channel = 1.5": "topography_channel = 1.5" + SIZED,
    "topography_channel = true": "topography_channel = true" + SIZED,
    "has no channels to choose from; remove .*channel": 'topography_channel = ""' + SIZED,
    "topography_channel = .*Height": 'topography_channel = ["Height"]' + SIZED,
}  # fmt: skip
ERRORS = {
    "psd_error has 1 rows and psd 2": "[[0.1]]",
    "rows of equal length": "[[0.1], [0.2, 0.1]]",
    "standard error ≥ 0 first": "[[-0.1], [0.2]]",
    "above -1": "[[0.1, -1], [0.2, 0]]",
    'psd_error = "large" must be a list': '"large"',
    "psd_error = 3 must be a list": "3",
    "psd_error.*nan must be a finite number": "[[nan], [0.2]]",
}


@pytest.fixture(autouse=True)
def library():
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)


def assert_no_scan(path, words, **given):
    with pytest.raises(rs.RecordError, match=f"{path.name}:? .*{words}") as refused:
        read_scan(path, **given)
    said = str(refused.value)
    assert not {word for word in ("\n", "tried", "codec") if word in said}
    assert len(said) < len(str(path.parent)) + 170


@pytest.mark.parametrize("name", NO_SCAN)
def test_scans_of_no_format_are_refused(tmp_path, name):
    content, words = NO_SCAN[name]
    (tmp_path / name).write_bytes(content)
    for given in ({}, GIVEN):
        assert_no_scan(tmp_path / name, words, **given)


@pytest.mark.parametrize("name", NO_HEIGHTS)
def test_scans_without_heights_are_refused(tmp_path, name):
    content, words = NO_HEIGHTS[name]
    (tmp_path / name).write_bytes(content)
    assert_no_scan(tmp_path / name, words, **GIVEN)


@pytest.mark.parametrize("name", NO_KEYS)
def test_scans_without_their_keys_are_refused(tmp_path, name):
    content, given, words = NO_KEYS[name]
    (tmp_path / name).write_bytes(content)
    assert_no_scan(tmp_path / name, words, **given)


def test_a_bomb_is_not_unpacked(tmp_path, memory):
    (tmp_path / "bomb.gz").write_bytes(gzip.compress(bytes(30_000_000)))
    memory(16e6)
    words = "unpacks to more than 0.002 GB, an eighth of the available memory"
    assert_no_scan(tmp_path / "bomb.gz", words)


@pytest.fixture
def scene_of(capped_scene, tmp_path):
    np.save(tmp_path / "a.npy", MAP)
    whole = capped_scene.to_toml()
    begin, end = whole.index("[surface]"), whole.index("[body]")

    def load(lines):
        if lines.startswith("\n"):
            lines = f'topography = "a.npy"{lines}'
        elif SIZED in lines:
            lines = f'topography = "a.npy"\n{lines}'
        (tmp_path / "scene.toml").write_text(f"{whole[:begin]}[surface]\n{lines}\n{whole[end:]}")
        return load_scene(tmp_path / "scene.toml")

    return load


@pytest.mark.parametrize("words", SCENES)
def test_wrong_keys_of_a_scan_are_refused(scene_of, words):
    assert_refused(lambda: scene_of(SCENES[words]), f"surface[. ].*({words})")


@pytest.mark.parametrize("words", ERRORS)
def test_wrong_errors_of_a_table_are_refused(scene_of, words):
    rows = 'psd = [[1e4, 3e-23], [1e5, 7e-27]]\npsd_convention = "persson"\npsd_source = "scan"'
    assert_refused(lambda: scene_of(f"{rows}\npsd_error = {ERRORS[words]}"), words)


def test_holes_are_filled_on_request_alone(scene_of, tmp_path):
    holes = MAP.copy()
    holes[:20, :20] = np.nan
    np.save(tmp_path / "a.npy", holes)
    words = r'13 % of its points are undefined, above 5 %; write topography_fill = "smooth"'
    assert_refused(lambda: scene_of(SIZED), words)
    words = r'topography_fill = "smoth" is not known; did you mean "smooth"'
    assert_refused(lambda: scene_of(SIZED + '\ntopography_fill = "smoth"'), words)
    holes[5:50, 5:45] = np.nan
    np.save(tmp_path / "a.npy", holes)
    words = "64.3 % of its points are undefined, above 50 %; crop it"
    assert_refused(lambda: scene_of(SIZED + '\ntopography_fill = "smooth"'), words)


def test_wrong_surfaces_are_not_written(capped_run, tmp_path):
    for words, call in {
        r"of a surface must end in .nc or .npy": lambda: export_surface(
            capped_run, tmp_path / "a.h5"
        ),
        "has not kept the fields of realization": lambda: export_surface(
            capped_run, tmp_path / "a.nc", realization=99
        ),
        r"shape \(3, 3\), but the grid has \(64, 48\)": lambda: encoded(
            np.zeros((3, 3)), GRID, ".nc"
        ),
    }.items():
        assert_refused(call, words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [".h5", ".nc", ".txt"])
@pytest.mark.parametrize("place", [0, 7, -1])
def test_an_undefined_coordinate_is_refused(tmp_path, suffix, place):
    path = tmp_path / f"a{suffix}"
    x = 1e-6 * np.arange(100)
    x[place] = np.nan
    if suffix == ".txt":
        path.write_bytes(text(np.column_stack([x, np.sin(np.arange(100))])))
    else:
        columns = {
            "x": x,
            "y": x[10] * np.arange(9),
            "z": np.random.default_rng(1).random((100, 9)),
        }
        with h5py.File(path, "w") as file:
            for name, values in columns.items():
                file[name] = values
                file[name].attrs["units"] = "m"
            for axis, name in enumerate("xy" if suffix == ".nc" else ""):
                file[name].make_scale(name)
                file["z"].dims[axis].attach_scale(file[name])
    given = {"unit": 1e-6} if suffix == ".txt" else {}
    with pytest.raises(rs.RecordError, match="at uneven steps; put its heights on even steps"):
        read_scan(path, **given)
