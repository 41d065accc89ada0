"""Scenes of a scan with a lay: surfaces have its directions, results an axis of them."""

import math
import runpy
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

import roughsim as rs
from roughsim import prediction
from roughsim.planning.limits import judge
from roughsim.prediction.scans import _few_in_directions, scan_error
from roughsim.scene import parse_scene
from roughsim.scene.files import load_map
from roughsim.surface.directions import Directions, with_lays
from roughsim.surface.topography.writing import encoded

SIDE = 4e-4
LAY = 0.5


def scene_of(folder, ratio, **sliding):
    """A scene of a map, 48 × 48 points, with a lay."""
    grid = rs.Grid((48, 48), (SIDE, SIDE))
    qx, qy = grid.wavevectors
    along = (qx * math.cos(LAY) + qy * math.sin(LAY)) * math.sqrt(ratio)
    across = (qy * math.cos(LAY) - qx * math.sin(LAY)) / math.sqrt(ratio)
    q = np.maximum(np.hypot(along, across), 6 * math.pi / SIDE)
    noise = np.fft.rfft2(np.random.default_rng(1).standard_normal(grid.shape))
    heights = np.fft.irfft2(noise * q**-1.8, grid.shape)
    (folder / "map.nc").write_bytes(encoded(4e-7 * heights / heights.std(), grid, ".nc"))
    body = {"youngs_modulus": 2e11, "poisson_ratio": 0.3, "penetration_hardness": 1.2e9}
    heat = {"conductivity": 30.0, "density": 7900.0, "heat_capacity": 500.0}
    slides = {"nominal_pressure": 9e7, "friction_coefficient": 0.11, "speed": [35.0]}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        content = {
            "surface": {"topography": str(folder / "map.nc")},
            "body": body | heat,
            "sliding": slides | sliding,
        }
        return content, rs.load_scene(content)


@pytest.fixture(scope="module")
def scanned(tmp_path_factory):
    """A map with a lay of 5: its content, and its scene."""
    return scene_of(tmp_path_factory.mktemp("scanned"), 5.0)


def test_a_scan_with_a_lay_has_directions_about_it(scanned):
    content, scene = scanned
    lay = scene.directed_angle
    assert abs(lay - LAY) < 0.05
    assert scene.directions == pytest.approx([lay, lay + math.pi / 4, lay + math.pi / 2])
    assert scene.headings == pytest.approx(scene.directions)
    assert scene.lay == 1.0  # the cell has equal sides
    assert scene.spectrum.directed
    assert sum(map(len, scene.surface.psd_directions)) <= 3000
    again = parse_scene(scene.to_toml())
    assert again == scene
    assert again.identity() == scene.identity()
    assert "surface.psd_directions" in scene.identity()
    warned = list(map(str, judge(scene).warnings))
    assert not any("is not isotropic:" in line for line in warned)
    # the map itself is pressed without them
    pressed, _ = load_map(content)
    assert not pressed.directions
    assert pressed.surface.psd_directions is None


def test_theory_and_law_of_a_scan_have_its_directions(scanned):
    scene = scanned[1].with_("sliding.speed", [1.0, 35.0])
    for values in columns(scene):
        slow, fast = values.T
        assert fast[0] > 1.2 * fast[1] > 1.2 * fast[2]
        assert slow[0] > slow[1] > slow[2]
    law = prediction.calibrated(scene)
    assert law.range == "inside"
    assert law.errors["flash_temperature"] > 0.1
    # in full contact, without a hardness, each mode has its pressure
    full = scene.with_("body.penetration_hardness", None).with_("sliding.nominal_pressure", 4e11)
    full = full.with_("sliding.speed", [35.0])
    exact = [full_contact(full, theta) for theta in full.directions]
    for values in columns(full):
        np.testing.assert_allclose(values, exact, rtol=1e-2)


def columns(scene):
    """T_flash by the theory and by the law, (directions, speeds)."""
    speeds, name = np.array(scene.speeds), "flash_temperature"
    theory = prediction.over_speed(scene, speeds, names=(name,))[name]
    law = prediction.calibrated_over_speed(scene, speeds)[name]
    return theory.reshape(3, -1), law.reshape(3, -1)


@pytest.mark.slow
def test_the_worked_example_of_a_ground_face(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    examples = Path(__file__).parents[2] / "docs" / "examples"
    runpy.run_path(str(examples / "ground.py"))
    shutil.copy(examples / "ground.toml", tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = rs.load_scene("ground.toml")
    (texture,) = scene.surface.psd_texture
    assert texture.ratio == pytest.approx(4.0, rel=0.05)
    assert math.degrees(texture.angle) == pytest.approx(30.0, abs=1.0)
    page = (examples.parent / "lay.md").read_text("utf-8")
    for kelvin in np.ravel(rs.theory(scene).to_dict()["flash_temperature"]):
        assert f" {kelvin:.1f} " in page


def test_few_waves_count_in_a_direction(scanned):
    scene = scanned[1].with_("sliding.speed", [1e-9, 35.0])
    few = _few_in_directions(scene, scene.surface)
    assert few.shape == (len(scene.surface.psd), 6)
    row, diffusivity = 20, 30.0 / (7900.0 * 500.0)
    q, factor = scene.surface.psd[row][0], scene.spectrum.factor

    angle = (np.arange(100_000) + 0.5) * (math.pi / 100_000)

    def mean(power, theta, speed):
        steep = np.cos(angle - theta) * speed / (diffusivity * q)
        return np.mean(
            (factor(np.full(angle.shape, q), angle) * ((1 - 1j * steep) ** -0.5).real) ** power
        )

    for k, theta in enumerate(scene.directions):
        for n, speed in enumerate((1e-9, 35.0)):
            exact = math.sqrt(mean(2, theta, speed)) / mean(1, theta, speed)
            assert few[row, 2 * k + n] == pytest.approx(exact, rel=0.02)
    # and the error, of which a part is by waves longer than the map, grows
    error = scan_error(scene, "flash_temperature")["flash_temperature"].reshape(3, 2)
    plain = scene.with_("surface.psd_directions", None).with_("surface.psd_texture", None)
    ratio = error / scan_error(plain)["flash_temperature"]
    assert (ratio > 1.05).all()
    assert (ratio[:, 1] > ratio[:, 0]).all()
    assert (ratio < few.max()).all()


def full_contact(scene, theta):
    """T_flash in full contact by the plane of waves, in turned even angles and q, at each speed."""
    spectrum, body = scene.spectrum, scene.conduction()
    ends = np.log([spectrum.breaks[0], spectrum.breaks[-1]])
    q = np.exp(np.linspace(*ends, 801))[:, None]
    angle = (np.arange(1440) + 0.5) * (math.pi / 1440)
    power = (scene.effective_modulus * q / 2) ** 2 * spectrum.at(q, angle) * q
    found = []
    for speed in scene.speeds[: len(scene.sliding.speed)]:
        root = np.sqrt(q**2 - 1j * q * np.cos(angle - theta) * speed / body.diffusivity)
        waves = (power / root).real.mean(axis=1) * 2 * math.pi * q[:, 0]
        heat = 0.11 * speed / body.conductivity / scene.sliding.nominal_pressure
        found.append(heat * np.trapezoid(waves, np.log(q[:, 0])))
    return found


def test_an_isotropic_scan_has_no_directions(tmp_path):
    _, scene = scene_of(tmp_path, 1.0)
    assert scene.surface.psd_directions is None
    assert not scene.directions
    assert not scene.spectrum.directed


def test_a_scan_with_crossed_lays_has_directions(tmp_path):
    # alike along both: no γ is found, but between them there are few waves
    content, _ = scene_of(tmp_path, 1.0)
    face = rs.SelfAffineSpectrum.from_rms_height(3e-7, hurst=0.8, q_min=7e4, q_max=4e5)
    lays = with_lays([(face, 4.0, 0.4), (face, 4.0, 0.4 + math.pi / 2)])
    grid = rs.Grid((192, 192), (2 * SIDE, 2 * SIDE))
    heights = rs.synthesize(lays.truncated(q_max=6e5), grid, np.random.default_rng(1))[:96, :96]
    np.save(tmp_path / "crossed.npy", heights)
    scan = {
        "topography": str(tmp_path / "crossed.npy"),
        "topography_size": f"{SIDE} m",
        "topography_unit": "m",
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = rs.load_scene(content | {"surface": scan})
    assert scene.surface.psd_texture[0].ratio < 1.3
    factor = scene.spectrum.factor
    assert factor.crossed
    q = np.full(2, 2e5)
    on, between = factor(q, np.array([0.4, 0.4 + math.pi / 4]))
    assert on > 3 * between


def test_the_part_of_crossed_lays_is_that_of_cos_4():
    angle = np.arange(45) * (math.pi / 45)
    for part, crossed in ((0.28, False), (0.32, True)):
        row = tuple((1 + part * np.cos(4 * angle - 1.0)).tolist())
        assert Directions((1e4, 1e5), (row, row)).crossed == crossed


def test_given_directions_replace_those_of_a_scan(tmp_path):
    _, scene = scene_of(tmp_path, 5.0, direction=["10 deg", "20 deg"])
    assert scene.directions == pytest.approx(np.radians([10, 20]))


def test_sliding_contacts_are_drawn_without_directions(tmp_path):
    _, scene = scene_of(tmp_path, 5.0)
    frozen = scene.content()
    frozen["sliding"] |= {
        "friction_coefficient": {"temperature": [300, 900], "value": [0.1, 0.2]},
        "background_temperature": 300.0,
    }
    tables = type(scene)(**frozen)
    assert not tables.directions
    assert not tables.spectrum.directed
    assert any("is not isotropic:" in str(line) for line in judge(tables).warnings)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("[[1e4, 1, 1], [1e4, 1, 1]]", "rising wavenumbers"),
        ("[[1e4, 1, -1]]", "rows of equal length, ≥ 0"),
        ("[[1e4, 0, 0]]", "not all 0"),
        ("[[1e4]]", "not all 0"),
        (f"[{', '.join([str([1e4 * (k + 1), *[1] * 60]) for k in range(50)])}]", "limit of 3000"),
    ],
)
def test_bad_directions_of_a_scene_are_refused(value, words):
    text = rs.load_scene("demo").to_toml()
    begin, rest = text.split("[surface]")
    body = rest[rest.index("[body]") :]
    rows = 'psd = [[1e5, 1e-27], [1e6, 1e-31]]\npsd_convention = "persson"\npsd_source = "scan"'
    with pytest.raises(ValueError, match=words):
        parse_scene(f"{begin}[surface]\n{rows}\npsd_directions = {value}\n{body}")


def test_directions_need_a_table():
    with pytest.raises(ValueError, match="psd_directions goes with psd_file only"):
        rs.load_scene("demo", {"surface.psd_directions": [[1e4, 1.0, 1.0]]})


@pytest.mark.slow
def test_a_run_of_a_scan_has_its_directions(tmp_path):
    _, scene = scene_of(tmp_path, 5.0)
    scene = scene.with_("ensemble.realizations", 2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = rs.run(scene.content(), tmp_path / "run", progress=False)
    found = rs.compare(run).columns["capped"]("flash_temperature").mean
    assert np.shape(found) == (3, 1)
    along, oblique, across = np.ravel(found)
    assert along > 1.2 * oblique > 1.2 * across
    assert isinstance(run.scene.spectrum.factor, Directions)
