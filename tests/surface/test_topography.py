"""Measured surfaces: their C(q) in our convention, whatever the file, and heights for other contact programs."""

import math
import shutil
from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim.cli import main
from roughsim.results.export import export_surface
from roughsim.scene import SceneError, load_scene
from roughsim.surface.topography.measured import combined, radial_average
from roughsim.surface.topography.reading import read_scan
from roughsim.surface.topography.writing import encoded

SIDE = 100e-6  # of the scans, m
GRID = rs.Grid((128, 128), (SIDE, SIDE))
UNIT = 2 * math.pi / SIDE


def spectrum(q_max=50):
    """Roll-off well inside the scan, end well below its Nyquist wavenumber."""
    return rs.SelfAffineSpectrum.from_rms_height(
        1e-7, hurst=0.8, q_min=UNIT, q_roll_off=6 * UNIT, q_max=q_max * UNIT
    )


def persson(q):
    """C(q) of `spectrum` by hand: a plateau, then q^(−2−2H), with 2π∫qCdq = (100 nm)²."""
    r, m, h = 6 * UNIT, 50 * UNIT, 0.8
    # 2π C₀ [ (r² − q₀²)/2 + r² (1 − (m/r)^(−2H)) / 2H ]
    norm = 2 * math.pi * ((r**2 - UNIT**2) / 2 + r**2 * (1 - (m / r) ** (-2 * h)) / (2 * h))
    return 1e-14 / norm * np.where(q < r, 1.0, (q / r) ** (-2 - 2 * h))


def spectrum_of(scan):
    return combined([scan.bins]).spectrum


@pytest.fixture(scope="module")
def library():
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ImportWarning)
        return pytest.importorskip("SurfaceTopography")


@pytest.fixture(scope="module")
def surface():
    return rs.synthesize(spectrum(), GRID, np.random.default_rng(4))


@pytest.fixture
def periodic(surface, tmp_path):
    (tmp_path / "scan.nc").write_bytes(encoded(surface, GRID, ".nc"))
    return tmp_path / "scan.nc"


@pytest.mark.usefixtures("library")
def test_the_spectrum_of_a_periodic_map_is_that_it_was_drawn_from(periodic, surface):
    found = read_scan(periodic)
    assert found.periodic
    np.testing.assert_allclose(found.heights, surface - surface.mean(), atol=1e-20)
    q = spectrum_of(found).q
    inside = (q > 15 * UNIT) & (q < 45 * UNIT)
    # fixed amplitudes: each mode has ∫C over its cell; C curves by (2+2H)²/24 (Δq/q)² < 0.3 % over it
    np.testing.assert_allclose(spectrum_of(found).psd[inside], persson(q[inside]), rtol=0.004)
    plateau = (q > 2.5 * UNIT) & (q < 5 * UNIT)
    np.testing.assert_allclose(spectrum_of(found).psd[plateau], persson(q[plateau]), rtol=1e-6)


@pytest.mark.usefixtures("library")
def test_height_and_slope_of_the_map_are_kept(periodic, surface):
    found = spectrum_of(read_scan(periodic))
    modes = np.fft.fft2(surface) / surface.size
    q = np.hypot(*np.meshgrid(*[2 * np.pi * np.fft.fftfreq(128, SIDE / 128)] * 2, indexing="ij"))
    assert found.rms_height == pytest.approx(surface.std(), rel=0.004)
    assert found.rms_slope == pytest.approx(math.sqrt((q**2 * np.abs(modes) ** 2).sum()), rel=0.004)


@pytest.mark.usefixtures("library")
def test_the_height_is_kept_where_the_longest_waves_carry_it(tmp_path):
    # no roll-off: half of the variance is in the modes of 2π/L, which no integral from 2π/L on holds
    steep = rs.SelfAffineSpectrum.from_rms_height(1e-7, hurst=0.8, q_min=UNIT, q_max=50 * UNIT)
    heights = rs.synthesize(steep, GRID, np.random.default_rng(2))
    (tmp_path / "a.nc").write_bytes(encoded(heights, GRID, ".nc"))
    found = spectrum_of(read_scan(tmp_path / "a.nc"))
    assert found.rms_height == pytest.approx(heights.std(), rel=1e-6)
    assert 0.4 * UNIT < found.breaks[0] < UNIT
    assert found(0.99 * UNIT) > found(1.01 * UNIT)  # it goes on rising
    assert found(found.breaks[0]) > 1.5 * found(UNIT)


def test_edges_raise_no_spectrum_where_the_surface_has_none(library, tmp_path):
    # an edge without a window adds C ∝ q⁻³; under it the spectrum above the end falls by four decades
    large = rs.Grid((384, 384), (3 * SIDE, 3 * SIDE))
    heights = rs.synthesize(spectrum(15), large, np.random.default_rng(0))[:128, :128]
    library.Topography(heights, (SIDE, SIDE), unit="m", periodic=False).to_x3p(
        str(tmp_path / "a.x3p")
    )
    found = spectrum_of(read_scan(tmp_path / "a.x3p"))
    assert found(25 * UNIT) < 1e-4 * found(14 * UNIT)


def test_the_convention_is_four_pi_squared_below_that_of_surfacetopography(library, surface):
    theirs = library.Topography(surface, (SIDE, SIDE), unit="m", periodic=True)
    q, psd = theirs.power_spectrum_from_area(nb_points_per_decade=20)
    ours = radial_average(
        np.abs(np.fft.rfft2(surface) / surface.size) ** 2 / UNIT**2, GRID, GRID.nyquist
    ).table
    inside = (q > 12 * UNIT) & (q < 40 * UNIT)
    ratio = np.asarray(psd)[inside] / ours(q[inside])
    np.testing.assert_allclose(
        ratio, 4 * math.pi**2, rtol=0.06
    )  # their bins err by the curvature of C within them
    assert ratio.mean() == pytest.approx(4 * math.pi**2, rel=0.03)


@pytest.mark.statistical
def test_a_map_with_edges_and_a_tilt_has_the_same_spectrum(library, tmp_path):
    # parts of a four times larger surface; the window leaves about 0.22 of its area
    large = rs.Grid((384, 384), (3 * SIDE, 3 * SIDE))
    parts, slopes = [], []
    for seed in range(5):
        heights = rs.synthesize(
            spectrum(), large, np.random.default_rng(seed), amplitudes="gaussian"
        )[:128, :128]
        x, y = np.meshgrid(np.arange(128) / 128, np.arange(128) / 128, indexing="ij")
        tilted = heights + 3e-6 * x - 5e-6 * y + 1e-3  # 50 times steeper than the roughness is high
        library.Topography(tilted, (SIDE, SIDE), unit="m", periodic=False).to_x3p(
            str(tmp_path / "scan.x3p")
        )
        found = read_scan(tmp_path / "scan.x3p")
        assert not found.periodic
        parts.append(spectrum_of(found)(UNIT * np.array([9.0, 14, 20, 28, 38])))
        slopes.append(spectrum_of(found).rms_slope)
    expected = persson(UNIT * np.array([9.0, 14, 20, 28, 38]))
    # 60 to 500 modes per bin, of which the window leaves one in five independent: below 20 % for one scan
    assert np.abs(np.mean(parts, axis=0) / expected - 1).max() < 4 * 0.2 / math.sqrt(5)
    assert np.mean(parts / expected) == pytest.approx(1, abs=0.06)
    assert np.mean(slopes) / spectrum().rms_slope == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("unit", ["um", "nm"])
def test_units_become_metres(library, surface, tmp_path, unit, periodic):
    factor = {"um": 1e6, "nm": 1e9}[unit]
    other = library.Topography(surface * factor, (SIDE * factor,) * 2, unit=unit, periodic=True)
    other.to_netcdf(str(tmp_path / "other.nc"))
    here, there = read_scan(periodic), read_scan(tmp_path / "other.nc")
    assert there.grid.lengths == pytest.approx((SIDE, SIDE))
    np.testing.assert_allclose(there.bins.psd, here.bins.psd, rtol=1e-6)  # their sizes are float32


@pytest.mark.usefixtures("library")
def test_an_oblong_map_keeps_its_axes(tmp_path):
    grid = rs.Grid((96, 160), (SIDE, 1.5 * SIDE))
    heights = rs.synthesize(spectrum(40), grid, np.random.default_rng(1))
    (tmp_path / "a.nc").write_bytes(encoded(heights, grid, ".nc"))
    found = read_scan(tmp_path / "a.nc")
    assert found.grid == grid
    np.testing.assert_allclose(found.heights, heights, atol=1e-20)
    q = spectrum_of(found).q[
        (spectrum_of(found).q > 10 * UNIT) & (spectrum_of(found).q < 35 * UNIT)
    ]
    np.testing.assert_allclose(spectrum_of(found)(q), spectrum(40)(q), rtol=0.02)


def test_the_instrument_s_resolution_ends_the_spectrum(library, surface, tmp_path):
    info = {
        "instrument": {
            "type": "microscope-based",
            "parameters": {"resolution": {"value": 5.0, "unit": "um"}},
        }
    }
    scan = library.Topography(surface * 1e6, (100.0, 100.0), unit="um", periodic=True, info=info)
    scan.to_netcdf(str(tmp_path / "a.nc"))
    assert spectrum_of(read_scan(tmp_path / "a.nc")).breaks[-1] == pytest.approx(
        2 * math.pi / 5e-6, rel=0.02
    )


def test_missing_points_are_filled_with_a_warning_or_refused(library, surface, tmp_path):
    few, many = (
        np.ma.masked_array(surface, np.zeros(GRID.shape, bool)),
        np.ma.masked_array(surface, surface > 0),
    )
    few.mask[40:44, 60:70] = True
    for name, heights in (("few", few), ("many", many)):
        library.Topography(heights, (SIDE, SIDE), unit="m").to_x3p(str(tmp_path / f"{name}.x3p"))
    with pytest.warns(RuntimeWarning, match=r"few.x3p: undefined points, 0.24 %, were filled"):
        assert np.isfinite(read_scan(tmp_path / "few.x3p").heights).all()
    with pytest.raises(
        rs.RecordError,
        match=r"many.x3p: .* % of its points are undefined, above 5 %; write topography_fill",
    ):
        read_scan(tmp_path / "many.x3p")


def test_a_missing_extra_says_what_to_type(without, tmp_path, scene_file, monkeypatch):
    without("SurfaceTopography")
    in_this_process = "roughsim.surface.topography.reading.call_in_child"  # the child does have it
    monkeypatch.setattr(in_this_process, lambda function, *arguments, seconds: function(*arguments))
    for name in ("scan.x3p", "scan.nc"):
        (tmp_path / name).write_bytes(b"\x01\x02\x03 of an instrument")
    with pytest.raises(ImportError, match=r"pip install 'roughsim\[topography\]'"):
        read_scan(tmp_path / "scan.x3p")
    with pytest.raises(
        SceneError,
        match=r"surface.topography = \"scan.nc\": .*pip install 'roughsim\[topography\]'",
    ):
        load_scene(scene_file)


@pytest.fixture
def scene_file(capped_scene, tmp_path):
    """A scene that names a scan beside it."""
    text = replace(capped_scene, title="scanned").to_toml()
    begin, end = text.index("[surface]"), text.index("[body]")
    path = tmp_path / "scene.toml"
    path.write_text(text[:begin] + '[surface]\ntopography = "scan.nc"\n\n' + text[end:])
    return path


@pytest.mark.usefixtures("library")
def test_a_scene_takes_its_roughness_from_a_scan_by_content(scene_file, periodic, surface):
    scene = load_scene(scene_file)
    measured = spectrum_of(read_scan(periodic))
    assert scene.surface.psd_convention == "persson"
    assert scene.spectrum.rms_height == pytest.approx(
        math.sqrt(2) * measured.rms_height, rel=1e-12
    )  # like = "body"
    assert scene.spectrum.rms_height == pytest.approx(math.sqrt(2) * surface.std(), rel=0.004)
    shutil.move(periodic, periodic.with_name("renamed.nc"))
    scene_file.write_text(scene_file.read_text().replace("scan.nc", "renamed.nc"))
    assert load_scene(scene_file).identity() == scene.identity()  # the name does not count
    periodic.with_name("renamed.nc").write_bytes(encoded(1.01 * surface, GRID, ".nc"))
    assert load_scene(scene_file).identity() != scene.identity()  # the content does


@pytest.mark.slow
@pytest.mark.usefixtures("library", "periodic")
def test_a_run_holds_the_measured_spectrum_and_goes_on_without_the_scan(scene_file, tmp_path):
    scene = load_scene(scene_file)
    levels = ({"column": "capped", "shape": [32, 32], "q_max": 8 * UNIT},)
    numerics = replace(scene.numerics, lengths=(2 * SIDE, 2 * SIDE), levels=levels)
    run = rs.run(replace(scene, numerics=numerics), tmp_path / "run", max_realizations=1)
    (tmp_path / "scan.nc").unlink()
    again = rs.open_run(run.folder)
    assert again.scene.spectrum.breaks == scene.spectrum.breaks
    # few long waves, none longer than the map: a part of the error, in a reopened run too
    for found in (run.estimate("flash_temperature"), again.estimate("flash_temperature")):
        relative = found.budget["scan"][1:] / found.mean[1:]
        assert found.budget["scan"][0] == 0.0  # nothing heats at rest
        assert ((relative > 0.03) & (relative < 0.6)).all()
        assert "scan: of C(q) measured on maps" in found.explain()
    unknown = replace(scene.surface, psd_error=None)  # as an older version stored it
    old = rs.run(
        replace(scene, surface=unknown, numerics=numerics), run.folder, max_realizations=1
    )  # the same bits
    assert np.isnan(old.estimate("flash_temperature").budget["scan"]).tolist() == [
        False,
        True,
        True,
    ]
    assert "scan: unknown" in old.estimate("flash_temperature").explain()
    stated = replace(scene.surface, psd_source=None, psd_error=None)
    own = rs.run(
        replace(scene, surface=stated, numerics=numerics), run.folder, max_realizations=1
    )  # the same bits
    assert (
        "scan" not in own.estimate("flash_temperature").budget
    )  # a table of one's own is taken as stated


@pytest.fixture(scope="module")
def kept_run(capped_scene, tmp_path_factory):
    numerics = replace(
        capped_scene.numerics,
        levels=({"column": "capped", "shape": [48, 32], "q_max": 4e4},),
        keep_fields=1,
    )
    scene = replace(capped_scene, numerics=replace(numerics, lengths=(3e-3, 2e-3)))
    return rs.run(scene, tmp_path_factory.mktemp("runs") / "kept", max_realizations=2)


def test_surfacetopography_reads_what_a_run_writes(library, kept_run, tmp_path):
    place = export_surface(kept_run, tmp_path / "new" / "surface.nc")
    back = library.read_topography(str(place))
    _, heights = next(kept_run.fields("heights"))
    np.testing.assert_array_equal(back.heights(), heights.astype(float))
    assert back.physical_sizes == (3e-3, 2e-3)
    assert (back.unit, back.is_periodic) == ("m", True)


def test_contactmechanics_starts_from_what_a_run_writes(library, kept_run, tmp_path):
    contact = pytest.importorskip("ContactMechanics")
    topography = library.read_topography(str(export_surface(kept_run, tmp_path / "surface.nc")))
    substrate = contact.PeriodicFFTElasticHalfSpace(
        topography.nb_grid_pts, 1.0, topography.physical_sizes
    )
    system = contact.Systems.NonSmoothContactSystem(substrate, topography)
    assert system.surface.nb_grid_pts == (48, 32)


def test_tamaas_starts_from_what_a_run_writes(kept_run, tmp_path):
    tamaas = pytest.importorskip("tamaas")
    heights = np.load(export_surface(kept_run, tmp_path / "surface.npy"), allow_pickle=False)
    assert heights.shape == (48, 32)
    model = tamaas.Model(tamaas.model_type.basic_2d, [3e-3, 2e-3], [48, 32])
    tamaas.PolonskyKeerRey(model, heights, 1e-8)


def test_xarray_reads_the_surface_too(kept_run, tmp_path):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(
        export_surface(kept_run, tmp_path / "surface.nc"), engine="scipy"
    ) as data:
        assert data.heights.dims == ("x", "y")
        assert data.heights.attrs["units"] == data.x.attrs["units"] == "m"
        np.testing.assert_allclose(data.y, np.arange(32) * 2e-3 / 32)


def test_the_command_line_writes_surfaces(kept_run, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["export", str(kept_run.folder), "-o", str(tmp_path / "a.npy"), "--surface", "0"])
    assert ended.value.code == 0
    _, heights = next(kept_run.fields("heights"))
    np.testing.assert_array_equal(np.load(tmp_path / "a.npy"), heights)
    with pytest.raises(SystemExit):
        main(
            [
                "export",
                str(kept_run.folder),
                "-o",
                str(tmp_path / "b.nc"),
                "--surface",
                "0",
                "--bits",
                "3",
            ]
        )
    assert "bits does not go with surface" in capsys.readouterr().err
