"""Maps as numbers alone (.txt, .csv, .npy), several maps of one surface, and the error of their C(q)."""

import math

import numpy as np
import pytest

import roughsim as rs
from roughsim.scene import SceneError, load_scene
from roughsim.surface.topography.measured import binned, combined, levelled, map_spectrum
from roughsim.surface.topography.reading import read_scan

SIDE = 100e-6
GRID = rs.Grid((64, 48), (SIDE, 0.75 * SIDE))
UNIT = 2 * math.pi / SIDE


@pytest.fixture(scope="module")
def library():
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ImportWarning)
        return pytest.importorskip("SurfaceTopography", exc_type=ImportError)


@pytest.fixture(scope="module")
def surface():
    spectrum = rs.SelfAffineSpectrum.from_rms_height(
        1e-7, hurst=0.8, q_min=2 * UNIT, q_max=25 * UNIT
    )
    return levelled(rs.synthesize(spectrum, GRID, np.random.default_rng(3)))


def write(folder, name, array, **how):
    path = folder / name
    np.save(path, array) if name.endswith("npy") else np.savetxt(path, array, **how)
    return path


@pytest.mark.parametrize(
    ("name", "how"),
    [
        ("a.npy", {}),
        ("a.txt", {"header": "heights in nm"}),
        ("a.csv", {"delimiter": ","}),
        ("b.csv", {"delimiter": ";"}),
    ],
)
def test_numbers_alone_are_heights_in_the_unit_given_row_by_row_along_x(
    tmp_path, surface, name, how, without
):
    without("SurfaceTopography")  # it is not needed
    path = write(tmp_path, name, surface * 1e9 + 5.0, **how)
    found = read_scan(path, size=GRID.lengths, unit=1e-9)
    assert (found.grid, found.periodic) == (GRID, False)
    np.testing.assert_allclose(found.heights, surface, atol=1e-12 * np.ptp(surface))


def test_the_spectrum_of_a_windowed_map_is_that_of_surfacetopography(library, surface, tmp_path):
    surface, side = (
        surface[:48],
        (GRID.lengths[1], GRID.lengths[1]),
    )  # a square: of a longer map several discs are used
    theirs = library.Topography(surface * 1e9, side, unit="m", periodic=False).detrend("rms-tilt")
    *_, whole = theirs.power_spectrum_from_area(return_map=True)
    path = write(tmp_path, "a.npy", surface * 1e9)
    found = read_scan(path, size=side, unit=1.0)
    # the variance under the window is the sum of their map, and theirs is 4π² of ours
    cell = 4 * math.pi**2 / math.prod(side)
    psd = whole.copy()
    psd[0, 0] = 0.0
    along = 2 * math.pi * np.fft.fftfreq(48, side[0] / 48)
    q = np.hypot(*np.meshgrid(along, along, indexing="ij"))
    inside = (q > 0) & (q <= found.grid.nyquist)
    assert found.bins.variance == pytest.approx(
        psd[inside].sum() * cell / (4 * math.pi**2), rel=1e-6
    )
    # and so is each bin, before it is put to its centre
    k = int(np.argmax(found.bins.q > 10 * UNIT))
    ends = 10 ** (found.bins.index[k] / 20), 10 ** ((found.bins.index[k] + 1) / 20)
    ring = psd[(q >= ends[0]) & (q < ends[1])] / (4 * math.pi**2)
    assert found.bins.psd[k] == pytest.approx(ring.mean(), rel=0.02)  # C curves within a bin


@pytest.mark.parametrize("end", [0.5, 1.0])
def test_modes_up_to_q_max_count_and_rounding_leaves_none_out(end):
    q = UNIT * np.arange(1, 101) * 1.1
    for q_max in (end * q[-1], np.nextafter(end * q[-1], 0.0), np.nextafter(end * q[-1], np.inf)):
        found = binned(q, q**-3.6, np.ones(100), 1.0, q_max)
        assert found.q_max == pytest.approx(end * q[-1], rel=1e-14)
        assert found.variance == pytest.approx((q[: round(100 * end)] ** -3.6).sum(), rel=1e-9)


@pytest.mark.statistical
def test_the_error_of_a_row_is_its_scatter_from_map_to_map():
    flat = rs.SelfAffineSpectrum.from_rms_height(
        1e-7, hurst=0.8, q_min=UNIT, q_roll_off=20 * UNIT, q_max=25 * UNIT
    )
    large = rs.Grid((192, 192), (3 * SIDE, 3 * SIDE))
    part = rs.Grid((64, 64), (SIDE, SIDE))
    rows = {True: [], False: []}
    for seed in range(60):
        rng = np.random.default_rng(seed)
        whole = rs.synthesize(flat, part, rng, amplitudes="gaussian")
        cut = levelled(rs.synthesize(flat, large, rng, amplitudes="gaussian")[:64, :64])
        for periodic, heights in ((True, whole), (False, cut)):
            found = map_spectrum(heights, part, periodic=periodic)
            wide = [
                slice(*np.searchsorted(found.q, ends))
                for ends in ((4 * UNIT, 8 * UNIT), (8 * UNIT, 16 * UNIT))
            ]
            rows[periodic].append([(found.psd[s].mean(), np.sqrt((found.error[s] ** 2).sum()) / len(found.psd[s]))
                                   for s in wide])  # fmt: skip
    for periodic, found in rows.items():
        psd, error = np.array(found).transpose(2, 0, 1)
        # rows of a windowed map are correlated, and their errors made larger for it: the means over several rows fit
        scatter = psd.std(axis=0) / psd.mean(axis=0)
        np.testing.assert_allclose(
            error.mean(axis=0), scatter, rtol=4 / math.sqrt(120) + 0.1, err_msg=str(periodic)
        )


@pytest.mark.usefixtures("library")
def test_several_maps_are_the_mean_in_each_bin_with_what_each_changes(surface):
    rough, smooth = (map_spectrum(factor * surface, GRID, periodic=True) for factor in (1.1, 0.9))
    spectrum, errors = combined([rough, smooth])
    (alone, error), third = combined([rough]), (1.1**2 + 0.9**2) / 2
    inside = slice(2, -3)
    q = spectrum.q[inside]
    np.testing.assert_allclose(
        spectrum(q), alone(q) / 1.1**2 * third, rtol=0.1
    )  # rows in the middle of bins
    # without the rough one the mean is the smooth one; of two maps half of each square counts
    np.testing.assert_allclose(errors[inside, 1], (0.9**2 / third - 1) * math.sqrt(0.5), rtol=1e-9)
    np.testing.assert_allclose(errors[inside, 2], (1.1**2 / third - 1) * math.sqrt(0.5), rtol=1e-9)
    # alike modes: the sum of squares of 1.1² and 0.9², over that of the mean, and over n²
    share = math.sqrt(1.1**4 + 0.9**4) / (2 * third)
    np.testing.assert_allclose(
        errors[inside, 0], share * np.interp(q, alone.q, error[:, 0]), rtol=0.2
    )


@pytest.mark.usefixtures("library")
def test_maps_of_several_sizes_join_their_bands():
    spectrum = rs.SelfAffineSpectrum.from_rms_height(1e-7, hurst=0.8, q_min=UNIT, q_max=100 * UNIT)
    rng = np.random.default_rng(1)
    fine_grid = rs.Grid((128, 128), (SIDE / 4, SIDE / 4))
    coarse = map_spectrum(
        rs.synthesize(spectrum.truncated(q_max=30 * UNIT), GRID, rng), GRID, periodic=True
    )
    ends = np.array([4 * UNIT, 100 * UNIT])  # the longest wave of the small map
    short = rs.TabulatedSpectrum(ends, spectrum(ends))
    fine = map_spectrum(rs.synthesize(short, fine_grid, rng), fine_grid, periodic=True)
    found, errors = combined([coarse, fine])
    assert found.breaks[0] < 1.01 * UNIT
    assert found.breaks[-1] == pytest.approx(fine.q_max)
    q = np.concatenate(
        [np.geomspace(12 * UNIT, 26 * UNIT, 10), np.geomspace(34 * UNIT, 80 * UNIT, 10)]
    )  # not the end
    np.testing.assert_allclose(found(q), spectrum(q), rtol=0.1)
    alone = (found.q < 3.8 * UNIT) | (found.q > 32 * UNIT)
    assert not errors[alone, 1:].any()  # one map alone shows no difference
    assert errors[~alone & (found.q > 12 * UNIT) & (found.q < 20 * UNIT), 1:].all()
    with pytest.warns(
        RuntimeWarning, match=r"the scans leave a gap from q = .* a factor .*; add a scan of a size"
    ):
        combined(
            [
                map_spectrum(
                    levelled(rng.standard_normal((64, 48))), GRID, periodic=True, reliable=2 * UNIT
                ),
                fine,
            ]
        )


@pytest.mark.usefixtures("library")
def test_points_that_are_not_finite_are_filled_if_they_are_few(tmp_path, surface):
    holes = surface.copy()
    holes[10, 10:14], holes[40, 3] = np.nan, np.inf
    with pytest.warns(RuntimeWarning, match=r"undefined points, 0.16 %, were filled"):
        found = read_scan(write(tmp_path, "a.npy", holes), size=GRID.lengths, unit=1.0)
    np.testing.assert_allclose(found.heights, surface, atol=0.2 * np.ptp(surface))
    assert np.isfinite(found.heights).all()


@pytest.fixture
def scene_of(capped_scene, tmp_path, surface):
    np.save(tmp_path / "a.npy", surface * 1e6)
    np.save(tmp_path / "b.npy", surface[::-1] * 1e6)
    text = capped_scene.to_toml()
    begin, end = text.index("[surface]"), text.index("[body]")

    def load(lines):
        (tmp_path / "scene.toml").write_text(f"{text[:begin]}[surface]\n{lines}\n{text[end:]}")
        return load_scene(tmp_path / "scene.toml")

    return load


def test_a_scene_reads_numbers_with_size_and_unit(scene_of, surface):
    scene = scene_of(
        'topography = "a.npy"\ntopography_size = ["100 um", "75 um"]\ntopography_unit = "µm"'
    )
    found = combined([map_spectrum(surface, GRID, periodic=False)])
    np.testing.assert_allclose(
        np.array(scene.surface.psd).T, (found.spectrum.q, found.spectrum.psd), rtol=1e-6
    )
    np.testing.assert_allclose(
        scene.surface.psd_error, found.errors, rtol=6e-3
    )  # three digits are kept
    assert load_scene_text(scene.to_toml()) == scene
    same = scene_of(
        'topography = "a.npy"\ntopography_size = [1e-4, 7.5e-5]\ntopography_unit = "1e-6 m"'.replace(
            "1e-6 m", "um"
        )
    )
    assert same == scene


def load_scene_text(text):
    from roughsim.scene.files import parse_scene

    return parse_scene(text)


@pytest.mark.usefixtures("library")
def test_a_scene_reads_a_list_of_scans(scene_of):
    lines = 'topography = ["a.npy", "b.npy"]\ntopography_unit = "um"\ntopography_size = '
    both, each = (
        scene_of(lines + '["100 um", "75 um"]'),
        scene_of(lines + '[["100 um", "75 um"], ["100 um", "75 um"]]'),
    )
    assert both == each
    assert {len(row) for row in both.surface.psd_error} == {3}
    assert both.scanned


@pytest.mark.usefixtures("library")
def test_a_scene_fills_undefined_points(scene_of, tmp_path, surface):
    holes = surface * 1e6
    holes[:20, :20] = np.nan
    np.save(tmp_path / "c.npy", holes)
    lines = 'topography = "c.npy"\ntopography_size = ["100 um", "75 um"]\ntopography_unit = "um"\n'
    with pytest.warns(RuntimeWarning, match="undefined points, 13 %, were filled"):
        scene = scene_of(lines + 'topography_fill = "smooth"')
    # weighted as in C(q), by the squares of the windows: the corner counts for less
    assert 0.01 < scene.surface.psd_filled < 0.13
    assert load_scene_text(scene.to_toml()) == scene


def test_a_scene_takes_line_scans_and_cannot_press_them(scene_of, tmp_path, surface):
    rng = np.random.default_rng(1)
    names = [f"line{k}.npy" for k in range(4)]
    for name in names:
        np.save(tmp_path / name, np.cumsum(rng.standard_normal(512)) * 1e-2)
    lines = f'topography = {names}\ntopography_size = "1 mm"\ntopography_unit = "um"'
    scene = scene_of(lines)
    assert scene.scanned
    assert scene.surface.psd_texture is None  # of a line nobody knows it
    assert len(scene.surface.psd_error[0]) == 1  # their mean C₁ is one
    q, psd = np.array(scene.surface.psd).T
    # a random walk of steps a has C₁ = a²/(2π Δx k²), and so C = C₁ Γ(3/2)/(√π Γ(1) k) = C₁/(2k)
    inside = (q > 2e5) & (q < 5e5)
    expected = (1e-8) ** 2 / (2 * math.pi * (1e-3 / 512)) / (2 * q[inside] ** 3)
    assert np.mean(psd[inside] / expected) == pytest.approx(1, abs=0.25)
    one = lines.replace(str(names), '"line0.npy"')
    scene_of(one)
    with pytest.raises(
        SceneError,
        match="line0.npy is a line scan, of which there is C.q., but no map to press; use run",
    ):
        rs.press(tmp_path / "scene.toml", tmp_path / "run")
