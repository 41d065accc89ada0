"""The map that C(q) was measured on, pressed once beside drawn surfaces: T_flash over that of maps of random phases."""

import json
from collections import defaultdict
from importlib import import_module

import numpy as np
import pytest

import roughsim as rs
from roughsim.cli import main
from roughsim.errors import ConvergenceError, RecordError
from roughsim.results.columns import results_of

SCANS = import_module("roughsim.prediction.scans")
BESIDE = import_module("roughsim.ensemble.map_beside")
POINTS, SIDE, SPEEDS = 48, 0.4e-3, (0.1, 30.0)
KAPPA, DIFFUSIVITY, FRICTION = 30.0, 30.0 / 7900 / 500, 0.11
HARDNESS, PRESSURE = 1.5e9, 8e7
SOLID = rs.Solid(2e11 / (1 - 0.3**2), HARDNESS)
LEVELS = [
    {"column": "capped", "shape": [32, 32], "q_max": 9e4},
    {"column": "capped", "shape": [64, 64], "q_max": 9e4},
]
SCENE = {
    "body": {
        "youngs_modulus": 2e11,
        "poisson_ratio": 0.3,
        "penetration_hardness": HARDNESS,
        "conductivity": KAPPA,
        "density": 7900.0,
        "heat_capacity": 500.0,
    },
    "sliding": {
        "nominal_pressure": PRESSURE,
        "friction_coefficient": FRICTION,
        "speed": list(SPEEDS),
        "heat_partition": 1,
    },
    "ensemble": {"realizations": 2},
    "numerics": {"lengths": [1e-3, 1e-3], "levels": LEVELS},
}
pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore::roughsim.SceneWarning")


@pytest.fixture(autouse=True)
def _no_scan_error(request, monkeypatch):
    """Leave out the error of C(q), which takes a second, where it is not asked for."""
    if "slow" not in request.keywords:
        monkeypatch.setattr(SCANS, "_error_of_face", lambda *_: defaultdict(float))
    SCANS.scan_error.cache_clear()
    yield
    SCANS.scan_error.cache_clear()


def drawn(seed):
    """Return a Gaussian map: a part of a larger one, with steps at its edges."""
    spectrum = rs.SelfAffineSpectrum.from_rms_height(
        6e-7, hurst=0.8, q_min=np.pi / SIDE, q_roll_off=8e4, q_max=3.5e5
    )
    whole = rs.Grid((2 * POINTS, 2 * POINTS), (2 * SIDE, 2 * SIDE))
    return rs.synthesize(spectrum, whole, np.random.default_rng(seed))[:POINTS, :POINTS]


def worn(seed):
    """Return a face whose highest half is worn off."""
    heights = drawn(seed)
    return np.minimum(heights, np.quantile(heights, 0.5))


def scene_of(folder, heights, **sections):
    """Return a scene with a map; its file stands in a folder."""
    np.save(folder / "map.npy", heights)
    surface = {
        "topography": str(folder / "map.npy"),
        "topography_size": SIDE,
        "topography_unit": "m",
    }
    return SCENE | {"surface": surface} | sections


def run_of(folder, heights, **sections):
    return rs.run(scene_of(folder, heights, **sections), folder / "run", progress=False)


def by_hand(heights, twins):
    """Return T_flash of the periodic part of a map over twins, on twice the points, by transforms written here."""
    ny = nx = POINTS
    steps = np.zeros((nx, ny))  # Moisan's periodic plus smooth
    steps[0] += heights[-1] - heights[0]
    steps[-1] -= heights[-1] - heights[0]
    steps[:, 0] += heights[:, -1] - heights[:, 0]
    steps[:, -1] -= heights[:, -1] - heights[:, 0]
    k = 2 * np.cos(2 * np.pi * np.fft.fftfreq(nx))
    laplacian = k[:, None] + k - 4
    laplacian[0, 0] = 1
    smooth = np.fft.fft2(steps) / laplacian
    smooth[0, 0] = 0
    modes = np.fft.fft2(heights) - smooth
    rng = np.random.default_rng(99)

    def flash(waves):
        fine = np.zeros((2 * nx, 2 * ny), complex)
        half = nx // 2
        k = np.fft.fftfreq(nx, 1 / nx).astype(int)
        inside = np.abs(k) < half
        fine[np.ix_(k[inside], k[inside])] = 4 * waves[np.ix_(inside, inside)]
        surface = np.fft.ifft2(fine).real
        grid = rs.Grid((2 * nx, 2 * ny), (SIDE, SIDE))
        contact = rs.solve_contact(surface, grid, SOLID, nominal_pressure=PRESSURE, tolerance=1e-3)
        source = rs.HeatSource(SPEEDS, FRICTION, KAPPA, DIFFUSIVITY)
        return rs.measure(contact, grid, source).flash_temperature

    phases = [np.fft.fft2(rng.standard_normal((nx, ny))) for _ in range(twins)]
    return flash(modes) / np.mean([flash(np.abs(modes) * z / np.abs(z)) for z in phases], axis=0)


def test_worn_map_is_as_cold_as_by_hand(tmp_path):
    run = run_of(tmp_path, worn(1))
    found, expected = run.map_ratio, by_hand(worn(1), 12)
    assert (found.ratio + found.error < 0.9).all()
    # the mean of 4 twins misses that of 12 by half of the interval of one more twin
    np.testing.assert_array_less(np.abs(found.ratio - expected), 0.6 * found.error)
    assert found.points == (2 * POINTS, 2 * POINTS)
    low, high = found.ratio.min(), found.ratio.max()
    value = f"{low:.2f} … {high:.2f} ± {found.error.max():.2f} times T_flash of drawn surfaces"
    assert value == found.statement.value


@pytest.mark.slow
def test_map_ratio_stands_beside_results(tmp_path, capsys):
    run = run_of(tmp_path, worn(1))
    words = f"{run.map_ratio.error.max():.2f} times T_flash of drawn surfaces"
    assert words in " ".join(str(rs.compare(run)).split())
    row = rs.compare(run).results["map_over_gaussian_twin"].sel(column="capped")
    np.testing.assert_array_equal(row.mean, run.map_ratio.ratio)
    np.testing.assert_array_equal(row.total_error, run.map_ratio.error)
    with pytest.raises(SystemExit, match="0"):
        main(["compare", str(run.folder), "--all"])
    assert "map_over_gaussian_twin" in capsys.readouterr().out
    assert "times T_flash of drawn surfaces" in rs.report(run).read_text()


def test_error_is_of_one_more_twin(tmp_path, monkeypatch):
    ratios = np.array([[0.5, 0.9], [0.45, 1.1], [0.55, 1.0], [0.6, 1.2]])
    monkeypatch.setattr(BESIDE, "over_twins", lambda *_: ratios)
    found = run_of(tmp_path, worn(1)).map_ratio
    twins = 1 / ratios  # T_flash over that of the map
    mean = twins.mean(axis=0)
    spread = np.sqrt(((twins - mean) ** 2).sum(axis=0) / 3 * (1 + 1 / 4))
    np.testing.assert_allclose(found.ratio, 1 / mean)
    np.testing.assert_allclose(found.error, 3.182446 * spread / mean**2, rtol=1e-6)


def test_gaussian_map_is_as_hot_as_drawn(tmp_path):
    found = run_of(tmp_path, drawn(2)).map_ratio
    assert (np.abs(found.ratio - 1) < found.error).all()
    assert (found.error < 0.5).all()


@pytest.mark.slow
def test_map_ratio_in_each_direction(tmp_path):
    x = np.arange(POINTS) * (2 * np.pi / POINTS)
    rng = np.random.default_rng(3)
    grooves = sum(
        1e-7 * np.cos(k * x + phase)
        for k, phase in zip(range(3, 12), rng.uniform(0, 6, 9), strict=True)
    )
    run = run_of(tmp_path, grooves + 0.2 * worn(3))
    assert run.scene.directions
    assert run.map_ratio.ratio.shape == (len(run.scene.directions) * len(SPEEDS),)
    row = results_of(run, ["map_over_gaussian_twin"])["map_over_gaussian_twin"]
    assert row.dims == ("column", "direction", "speed")


def test_map_ratio_is_stored_once(tmp_path, monkeypatch):
    run = run_of(tmp_path, worn(1))
    path = run.folder / "map.json"
    text = path.read_bytes()
    path.unlink()  # as of a run that was killed before
    again = run_of(tmp_path, worn(1))
    assert path.read_bytes() == text
    monkeypatch.setattr(BESIDE, "over_twins", None)
    run_of(tmp_path, worn(1))
    assert path.read_bytes() == text
    path.write_bytes(text.replace(b'"points": [\n  9', b'"points": [\n  8'))
    with pytest.raises(RecordError, match=r"map.json is damaged \(its checksum"):
        _ = again.map_ratio


def test_large_map_is_left_to_press(tmp_path, monkeypatch):
    monkeypatch.setattr(BESIDE, "_SIDES", (32, 2048))
    run = run_of(tmp_path, worn(1))
    assert run.map_ratio.ratio.size == 0
    assert (
        "map: not solved on 96 × 96 points; this takes longer than the run; `roughsim press`"
        in (str(rs.compare(run)).replace("\n", " "))
    )
    assert "map_over_gaussian_twin" not in rs.compare(run).results
    # a longer run has the time
    longer = run_of(tmp_path, worn(1), ensemble={"realizations": 12})
    assert longer.map_ratio.ratio.size == 2


def test_map_that_fails_is_reported(tmp_path, monkeypatch):
    def fail(*_):
        raise ConvergenceError("no contact", 1.0, 1)

    monkeypatch.setattr(BESIDE, "over_twins", fail)
    assert "not solved on 96 × 96 points; no contact" in str(
        run_of(tmp_path, worn(1)).map_ratio.statement
    )


def test_run_of_loaded_scene_has_no_map(tmp_path):
    scene = rs.load_scene(scene_of(tmp_path, worn(1)))
    run = rs.run(scene, tmp_path / "run", progress=False)
    assert run.map_ratio is None
    assert not (run.folder / "map.json").exists()


@pytest.mark.slow
def test_run_command_states_the_map(tmp_path, capsys):
    scene = rs.load_scene(scene_of(tmp_path, worn(1))).to_toml()
    surface = f'topography = "{tmp_path}/map.npy"\ntopography_size = {SIDE}\ntopography_unit = "m"'
    rest = "[body]" + scene.partition("[body]")[2]
    (tmp_path / "s.toml").write_text(f"[surface]\n{surface}\n{rest}")
    with pytest.raises(SystemExit, match="0"):
        main(["run", str(tmp_path / "s.toml"), "-o", str(tmp_path / "run")])
    assert "times T_flash of drawn surfaces" in capsys.readouterr().out.replace("\n", " ")
    assert len(json.loads((tmp_path / "run" / "map.json").read_text())["ratio"]) == len(SPEEDS)
