"""A pressed map by the direction of sliding, and over its Gaussian twin."""

import json
import math
import warnings
from dataclasses import replace
from importlib import import_module
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from some_rows import some

import roughsim as rs
from roughsim.cli import main
from roughsim.contact import Contact
from roughsim.errors import RecordError
from roughsim.observables.temperatures import flash_temperature_along
from roughsim.planning.realization import level_problem
from roughsim.results.export import export_run
from roughsim.results.pressed import overshoot
from roughsim.surface.topography.periodic import (
    band_limited,
    gaussian_twin,
    mirrored,
    overshoots,
    periodic_part,
)
from roughsim.surface.topography.writing import encoded

press_module = import_module("roughsim.ensemble.map_cells")
SIDE = 0.5e-3
SPEEDS = (0.2, 20.0)
KAPPA, DIFFUSIVITY, FRICTION = 30.0, 30.0 / 7900 / 500, 0.11
SCENE = {
    "body": {
        "youngs_modulus": 2e11,
        "poisson_ratio": 0.3,
        "penetration_hardness": 2e9,
        "conductivity": KAPPA,
        "density": 7900.0,
        "heat_capacity": 500.0,
    },
    "sliding": {
        "nominal_pressure": 5e7,
        "friction_coefficient": FRICTION,
        "speed": list(SPEEDS),
        "direction": "30 deg",
        "heat_partition": 1,
    },
}


@pytest.fixture(autouse=True)
def _long_waves():
    with warnings.catch_warnings():  # C(q) of a map goes on a little beyond its sides
        warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
        yield


def grooved(stretch=4.0, seed=1):
    """A periodic Gaussian map with waves longer along x."""
    grid = rs.Grid((96, 96), (SIDE / stretch, SIDE))
    law = rs.SelfAffineSpectrum.from_rms_height(4e-7, hurst=0.8, q_min=5e4, q_max=2.5e5)
    return rs.synthesize(law, grid, np.random.default_rng(seed))


def pressed(folder, heights, edges=None, **changes):
    """Press a periodic map."""
    folder.mkdir()
    grid = rs.Grid(heights.shape, (SIDE, SIDE))
    (folder / "map.nc").write_bytes(encoded(heights, grid, ".nc"))
    scene = {"surface": {"topography": str(folder / "map.nc")}} | SCENE
    return rs.press(scene, folder / "press", edges=edges, changes=changes)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
        return pressed(tmp_path_factory.mktemp("grooves") / "map", grooved())


def test_a_wave_has_the_flash_temperature_of_its_own_direction():
    # σ = σ₀(1 + cos qx): ⟨Tσ⟩/σ₀ = ½ μvσ₀/κ Re(1/λ), λ = √(q² − i q v/D) along the wave, q across it
    grid, q, speed, load = rs.Grid((32, 16), (1e-3, 5e-4)), 2 * math.pi * 3 / 1e-3, 0.05, 1e7
    pressure = load * (1 + np.cos(q * 1e-3 / 32 * np.arange(32)))[:, None] * np.ones(16)
    sliding = rs.HeatSource((speed, 2 * speed), FRICTION, KAPPA, DIFFUSIVITY, heat_partition=0.4)
    heat = 0.4 * FRICTION * load / KAPPA
    for direction, component in ((0.0, q), (math.pi / 2, 0.0), (0.7, q * math.cos(0.7))):
        found = flash_temperature_along(pressure, grid, sliding, direction, slid_distance=1.0)
        for k, v in enumerate((speed, 2 * speed)):
            expected = 0.5 * heat * v * (1 / np.sqrt(q**2 - 1j * component * v / DIFFUSIVITY)).real
            assert found[k] == pytest.approx(expected, rel=1e-9)


def test_directions_of_an_isotropic_contact_are_not_raised_by_hot_tracks():
    # steady in one direction each spot slides in its own track for ever: 10 % too high here; from rest it is not
    law = rs.SelfAffineSpectrum.from_rms_height(
        4e-7, hurst=0.8, q_min=2.5e4, q_roll_off=1e5, q_max=4e5
    )
    grid = rs.Grid((128, 128), (SIDE, SIDE))
    over = []
    for seed in range(3):
        heights = rs.synthesize(law, grid, np.random.default_rng(seed))
        contact = rs.solve_contact(
            heights, grid, rs.Solid(2e11 / 0.91, 2e9), nominal_pressure=5e7, tolerance=1e-3
        )
        sliding = rs.HeatSource((35.0,), FRICTION, KAPPA, DIFFUSIVITY)
        mean = rs.measure(contact, grid, sliding).flash_temperature
        angles = np.arange(8) * math.pi / 8
        over += [
            flash_temperature_along(contact.pressure, grid, sliding, angle) / mean
            for angle in angles
        ]
    assert np.mean(over) == pytest.approx(1.0, abs=0.03)


def test_a_mirrored_cell_has_the_directions_of_the_map_alone(run):
    # oblique stripes: their mirror images run the other way, and would share the heat between both directions
    x = np.arange(48) / 48
    stripes = 1e8 * (1 + np.cos(2 * math.pi * (6 * x[:, None] + 3 * x)))
    lay = math.atan2(6, -3)  # of the stripes, across (6, 3)
    angles = {"along": lay, "across": lay - math.pi / 2}
    found = {}
    for edges, pressure in (("tile", stripes), ("mirror", mirrored(stripes))):
        side = SIDE * pressure.shape[0] / 48
        like = level_problem(run.scene, run.numerics, 0)
        of_cell = replace(like, grid=rs.Grid(pressure.shape, (side, side)))
        contact = Contact(pressure, 0.0 * pressure, 1.0, 0.0, 0.0, 1, 1.0)
        found[edges] = press_module.over_mean(
            of_cell, SimpleNamespace(contact=contact), angles, edges
        )
    assert found["mirror"] == found["tile"]
    assert found["tile"]["along"][-1] > 2
    assert found["tile"]["across"][-1] < 1


def test_the_press_of_grooves_gives_both_principal_directions_and_the_one_asked_for(run):
    last = run.numerics.of_column("capped")[-1]
    level, grid = run.numerics.levels[last], run.numerics.grid(last)
    heights = band_limited(grooved(), rs.Grid((96, 96), (SIDE, SIDE)), level.shape, level.q_max)
    contact = rs.solve_contact(
        heights, grid, rs.Solid(2e11 / 0.91, 2e9), nominal_pressure=5e7, tolerance=1e-4
    )
    assert run.angles["asked"] == pytest.approx(math.pi / 6)
    assert math.sin(run.angles["along"]) == pytest.approx(0.0, abs=1e-3)  # the search ends within
    mean = rs.measure(
        contact, grid, rs.HeatSource(SPEEDS, FRICTION, KAPPA, DIFFUSIVITY)
    ).flash_temperature
    for name, angle in (("along", 0.0), ("across", math.pi / 2), ("asked", math.pi / 6)):
        estimate = run.in_direction(name)
        ratio = estimate.mean / run.estimate("flash_temperature").mean
        for k, speed in enumerate(SPEEDS):
            heat = FRICTION * speed * contact.pressure
            field = rs.sliding_temperature(
                heat,
                grid,
                speed=speed,
                conductivity=KAPPA,
                diffusivity=DIFFUSIVITY,
                direction=angle,
            )
            expected = np.mean(field * contact.pressure) / 5e7 / mean[k]
            assert ratio[k] == pytest.approx(expected, rel=0.01)  # the tolerance of both contacts
        # where heat hardly moves on, the steady moments of one direction say the same
        steady = rs.measure(
            contact, grid, rs.HeatSource(SPEEDS, FRICTION, KAPPA, DIFFUSIVITY, 1.0, angle)
        )
        assert ratio[0] == pytest.approx(steady.flash_temperature[0] / mean[0], rel=0.03)
        assert np.all(
            estimate.total_error >= run.estimate("flash_temperature").total_error * ratio * 0.999
        )
    assert run.in_direction("along").mean[-1] > 1.5 * run.in_direction("across").mean[-1]


@pytest.mark.slow
def test_a_map_turned_by_a_right_angle_exchanges_along_and_across(run, tmp_path):
    turned = pressed(tmp_path / "turned", grooved().T.copy())
    assert turned.angles["along"] == pytest.approx(math.pi / 2, abs=1e-3)
    for name in ("along", "across"):
        np.testing.assert_allclose(
            turned.in_direction(name).mean, run.in_direction(name).mean, rtol=1e-3
        )


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_table_json_and_report_have_directions_and_twin_and_compute_nothing(
    run, calls, capsys, tmp_path
):
    solved = calls(press_module, "solve_problem")
    with pytest.raises(SystemExit, match="0"):
        main(["compare", str(run.folder)])
    text = " ".join(capsys.readouterr().out.split())
    for words in (
        "flash_temperature_along",
        "flash_temperature_across",
        "at 30°",
        "map over Gaussian twin: ",
        f"{run.over_twin[1]:.4g} ± unknown",  # one twin shows no scatter
    ):
        assert words in text
    assert "texture: waves" in text
    with pytest.raises(SystemExit, match="0"):
        main(["compare", str(run.folder), "--json"])
    table = json.loads(capsys.readouterr().out)
    assert table["directions"]["asked"] == pytest.approx(math.pi / 6)
    found = {(row["observable"], row["speed"]): row["capped"]["mean"] for row in table["rows"]}
    assert found["flash_temperature_along", 20.0] == pytest.approx(
        run.in_direction("along").mean[1]
    )
    assert found["map_over_gaussian_twin", 0.2] == pytest.approx(run.over_twin[0])
    page = rs.report(run, tmp_path / "page.html").read_text()
    assert "map_over_gaussian_twin" in page
    assert "texture" in page
    assert solved == []
    with h5py.File(export_run(run, tmp_path / "numbers.h5")) as file:
        results = file["results"]
        capped = [text.decode() for text in results["column"]].index("capped")
        np.testing.assert_allclose(results["map_over_gaussian_twin"][capped], run.over_twin)
        name, along = "flash_temperature_by_direction", run.in_direction("along")
        place = (capped, [text.decode() for text in results["direction"]].index("along"))
        np.testing.assert_allclose(results[name][place], along.mean)
        np.testing.assert_allclose(results["angle"], [*run.angles.values()])
        assert results["angle"].attrs["units"] == "rad"
        np.testing.assert_allclose(results[f"{name}_total_error"][place], along.total_error)


def test_flattened_tops_lie_far_below_their_gaussian_twin_and_a_gaussian_map_near_it(run, tmp_path):
    heights = grooved(1.0)
    flat = pressed(tmp_path / "flat", np.minimum(heights, np.quantile(heights, 0.8)))
    assert np.all(flat.over_twin < 0.6)
    plain = pressed(tmp_path / "plain", heights)
    assert np.all(np.abs(np.log(plain.over_twin)) < 0.35)  # one twin scatters by about 0.1


def test_a_twin_has_the_spectrum_of_the_map_and_gaussian_heights():
    rng = np.random.default_rng(3)
    for shape in ((64, 64), (63, 50), (50, 63)):
        heights = 1.0 + np.exp(rng.standard_normal(shape))
        twin = gaussian_twin(heights, rng)
        np.testing.assert_allclose(
            np.abs(np.fft.fft2(twin)), np.abs(np.fft.fft2(heights)), rtol=1e-9
        )
        standard = (twin - twin.mean()) / twin.std()
        assert np.mean(standard**3) == pytest.approx(0.0, abs=4 * math.sqrt(6 / twin.size))
        assert np.mean(standard**4) == pytest.approx(3.0, abs=4 * math.sqrt(24 / twin.size))


def test_the_periodic_part_lacks_a_surface_that_is_harmonic_inside():
    rng = np.random.default_rng(4)
    heights = rng.standard_normal((40, 31)) + 20 * np.arange(40)[:, None] / 40
    part = periodic_part(heights)
    smooth = heights - part
    inside = (
        smooth[2:, 1:-1]
        + smooth[:-2, 1:-1]
        + smooth[1:-1, 2:]
        + smooth[1:-1, :-2]
        - 4 * smooth[1:-1, 1:-1]
    )
    np.testing.assert_allclose(inside, 0.0, atol=1e-12)
    assert part.mean() == pytest.approx(heights.mean())
    assert np.abs(part[0] - part[-1]).mean() < 4 < np.abs(heights[0] - heights[-1]).mean()
    wave = np.cos(2 * np.pi * (3 * np.arange(40)[:, None] / 40 + 2 * np.arange(31) / 31))
    # what has no step but its own slope at the edges is left nearly as it is
    assert np.abs(periodic_part(wave) - wave).max() < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("edges", ["tile", pytest.param("mirror", marks=pytest.mark.slow)])
def test_the_press_of_a_map_whose_waves_overshoot_beside_spikes_has_an_unknown_error(
    tmp_path, edges
):
    heights = grooved(1.0)
    clean = pressed(tmp_path / "clean", heights, edges=edges)
    valleys = np.flatnonzero(heights < 0.0)
    heights.flat[np.random.default_rng(2).choice(valleys, 5, replace=False)] -= 70 * heights.std()
    spiked = pressed(tmp_path / "spiked", heights, edges=edges)
    assert overshoot(clean.members) == 0.0
    share = overshoot(spiked.members)
    assert share > 0.05
    assert "bandwidth" in spiked.estimate("flash_temperature").unknown
    assert "bandwidth" not in clean.estimate("flash_temperature").unknown
    (warning,) = (line for line in spiked.warnings if "overshoot" in line)
    assert f"{100 * share:.2g} % of the load is on heights that the map does not have" in warning
    assert warning in " ".join(str(rs.compare(spiked)).split())
    assert not any("overshoot" in line for line in clean.warnings)


def test_only_what_stands_far_above_all_points_around_is_an_overshoot():
    x = np.arange(32)
    wave = np.cos(2 * np.pi * 3 * x / 32)[:, None] + np.cos(2 * np.pi * 2 * x / 32)
    grid, shape = rs.Grid((32, 32), (1.0, 1.0)), (128, 128)
    assert not overshoots(
        band_limited(wave, grid, shape, grid.nyquist), wave, grid, grid.nyquist
    ).any()
    spiked = wave.copy()
    spiked[10, 12] -= 100.0
    found = overshoots(band_limited(spiked, grid, shape, grid.nyquist), spiked, grid, grid.nyquist)
    assert not found[40, 48]  # the spike
    assert not found[::4, ::4].any()  # the points of the map
    assert found[46, 48]  # 1.5 points beside it, where sin(πx)/(πx) = −0.21
    assert found[40, 54]
    assert not overshoots(np.ones(shape), np.ones((32, 32)), grid, grid.nyquist).any()


def test_a_run_that_draws_from_a_map_with_spikes_does_not_know_its_error(tmp_path):
    heights = grooved(1.0)
    heights.flat[np.random.default_rng(2).choice(heights.size, 5, replace=False)] = (
        -70 * heights.std()
    )
    (tmp_path / "map.nc").write_bytes(encoded(heights, rs.Grid(heights.shape, (SIDE, SIDE)), ".nc"))
    level = {"column": "capped", "shape": [64, 64], "q_max": 2e5}
    scene = SCENE | {
        "surface": {"topography": str(tmp_path / "map.nc")},
        "sliding": {key: value for key, value in SCENE["sliding"].items() if key != "direction"},
        "numerics": {"levels": [level], "lengths": 4 * SIDE / 4},
        "ensemble": {"max_realizations": 3},
    }
    drawn = rs.run(rs.load_scene(scene), tmp_path / "run")
    assert "scan" in drawn.estimate("flash_temperature").unknown
    table = str(rs.compare(drawn))
    assert "not Gaussian" in table
    assert "roughsim press" in " ".join(table.split())


@pytest.mark.parametrize(
    "forged",
    some([{"angles": {"along": 0.1}, "over_mean": {"along": [1.0]}}, {}, {"angles": 3}]),
)
def test_forged_directions_are_refused_by_the_name_of_their_member(monkeypatch, tmp_path, forged):
    monkeypatch.setattr(
        press_module.MapCells, "about", lambda *_: {"directions": forged, "overshoot": 0.0}
    )
    found = pressed(tmp_path / "forged", grooved(seed=2))
    with pytest.raises(
        RecordError, match=r"L1-000000 of .* has directions .*; press into a new folder"
    ):
        _ = found.angles
