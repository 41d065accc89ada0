"""A pressed map has all of its own waves and no others, and its value is the limit of the pixel."""

import itertools
import math
import warnings

import numpy as np
import pytest
from press_cases import AT_35, GRID, SIDE, levelled, on_finer_points, write_scene

import roughsim as rs
from roughsim.ensemble.press import resolution_of
from roughsim.scene import parse_scene
from roughsim.surface.topography.periodic import band_limited, mirrored, refined

NAME = "flash_temperature"


@pytest.fixture(autouse=True)
def _long_waves():
    with warnings.catch_warnings():  # C(q) of a map goes on a little beyond its sides
        warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
        yield


@pytest.fixture(scope="module")
def elastic_case(capped_scene):
    lines = [
        line
        for line in capped_scene.to_toml().splitlines()
        if not line.startswith("penetration_hardness")
    ]
    return parse_scene(
        "\n".join(line.replace('"capped"', '"elastic"') for line in lines if "smoothed" not in line)
    )


def rough_to_the_pixel(hurst, seed=0, rms_height=3e-7):
    """A periodic map whose roughness goes on to its Nyquist wavenumber, as that of instruments does."""
    q_min = 2 * math.pi / min(GRID.lengths)
    spectrum = rs.SelfAffineSpectrum.from_rms_height(
        rms_height, hurst=hurst, q_min=q_min, q_max=GRID.nyquist
    )
    return rs.synthesize(spectrum, GRID, np.random.default_rng(seed), amplitudes="gaussian")


def reference(run, heights, lengths):
    """T_flash at all speeds of the scene from 4 and 8 times finer points, in the limit, and what 8 times lacks."""
    scene, values = run.scene, []
    bodies = scene.conduction()
    sliding = rs.HeatSource(speeds=[v or 1e-9 for v in scene.speeds], friction_coefficient=scene.friction_coefficient(),
                         conductivity=bodies.conductivity, diffusivity=bodies.diffusivity)  # fmt: skip
    for factor in (4, 8):
        fine = on_finer_points(heights, factor)
        grid = rs.Grid(fine.shape, lengths)
        solid = rs.Solid(scene.effective_modulus, scene.penetration_hardness)
        pressure = scene.sliding.nominal_pressure
        contact = rs.solve_contact(fine, grid, solid, nominal_pressure=pressure, tolerance=1e-5)
        values.append(rs.measure(contact, grid, sliding).flash_temperature * run.heat_partition)
    return 2.0 * values[1] - values[0], np.abs(values[1] - values[0])


CASES = itertools.product([0.3, 0.5, 0.8], ["0.6 GPa", "2 GPa", "elastic"], ["tile", "mirror"])
QUICK = {  # the others are slow
    (0.8, "0.6 GPa", "tile"),
}


@pytest.mark.parametrize(
    ("hurst", "hardness", "edges"),
    [
        pytest.param(
            *case, marks=() if case in QUICK else pytest.mark.slow, id="-".join(map(str, case))
        )
        for case in CASES
    ],
)
def test_the_value_of_a_map_is_that_of_its_own_waves_on_ever_finer_points(
    capped_scene, elastic_case, tmp_path, hurst, hardness, edges
):
    heights = rough_to_the_pixel(hurst)
    scene = (
        elastic_case
        if hardness == "elastic"
        else capped_scene.with_("body.penetration_hardness", hardness)
    )
    run = rs.press(write_scene(tmp_path, heights, scene), tmp_path / "run", edges=edges)
    found = run.estimate(NAME)
    plane = levelled(heights)
    cell, factor = (plane, 1) if edges == "tile" else (mirrored(plane), 2)
    expected, left = reference(run, cell, tuple(factor * side for side in GRID.lengths))
    # the statistical part is that of other maps; each solve is off by its tolerance of 1e-4 at most
    of_map = found.budget["pixel"] + left + 3e-4 * expected
    assert (np.abs(found.mean - expected) <= of_map)[1:].all()
    np.testing.assert_allclose(found.mean[1:], expected[1:], rtol=0.01)
    assert found.budget["bandwidth"].max() == 0.0  # the map has no shorter waves
    assert "bandwidth" not in found.unknown
    assert "last step" not in found.budget
    assert "continued from q_c" not in found.explain()
    assert "extrapolated as q_c" not in found.explain()


def test_finer_points_keep_the_heights_between_them_wave_by_wave():
    heights = np.random.default_rng(3).standard_normal(
        (12, 14)
    )  # all waves, those of the Nyquist wavenumber too
    fine = refined(heights, (24, 56))
    np.testing.assert_allclose(fine[::2, ::4], heights, atol=1e-12)
    np.testing.assert_allclose(refined(heights, (12, 14)), heights, atol=1e-12)
    np.testing.assert_allclose(refined(heights, (36, 42)), on_finer_points(heights, 3), atol=1e-12)
    odd = np.random.default_rng(3).standard_normal((13, 15))
    np.testing.assert_allclose(refined(odd, (39, 45)), on_finer_points(odd, 3), atol=1e-12)


def points(n, pixel=1e-6):
    return rs.Grid((n, n), (n * pixel, n * pixel))


def test_a_map_has_its_waves_up_to_the_nyquist_wavenumber_and_as_many_pixels_as_there_is_room_for(
    capped_scene,
):
    all_waves = capped_scene.with_("surface.q_max", 1e8)
    nyquist = math.pi / 1e-6
    assert resolution_of(all_waves, points(512)) == (pytest.approx(nyquist), 4.0, True)
    assert resolution_of(all_waves, points(520)) == (pytest.approx(nyquist), 2.0, True)
    assert resolution_of(all_waves, points(2048)) == (pytest.approx(nyquist), 2.0, True)
    assert resolution_of(all_waves, points(4096)) == (
        pytest.approx(nyquist / 2, rel=1e-5),
        2.0,
        False,
    )
    q_max, pixels, whole = resolution_of(
        capped_scene, points(128)
    )  # C(q) ends below, as the instrument says
    assert (q_max, pixels, whole) == (2e5, 4.0, True)
    oblong = rs.Grid((128, 64), (1.28e-4, 1.28e-4))  # pixels of 1 and 2 µm
    assert resolution_of(all_waves, oblong).q_max == pytest.approx(nyquist / 2)


@pytest.mark.parametrize("kind", [pytest.param("capped", marks=pytest.mark.slow), "elastic"])
def test_a_map_of_too_many_points_loses_its_shortest_waves_and_the_last_step_is_in_the_error(
    capped_scene, elastic_case, tmp_path, monkeypatch, kind
):
    monkeypatch.setattr("roughsim.ensemble.press.MOST_SIDE", 64)
    scene = (
        capped_scene if kind == "capped" else elastic_case
    )  # the theory could continue the elastic one
    path = write_scene(tmp_path, rough_to_the_pixel(0.8), scene)
    run = rs.press(path, tmp_path / "run", edges="tile", changes=AT_35)
    q_max = math.pi * 64 / SIDE * (1 - 1e-6)  # of 64 points along the longer side
    expected = [((32, 22), q_max / 2), ((64, 44), q_max / 2), ((64, 44), q_max), ((128, 88), q_max)]
    levels = [run.numerics.levels[level] for level in run.numerics.of_column(kind)]
    assert [(level.shape, pytest.approx(level.q_max)) for level in levels] == expected
    found, samples = run.estimate(NAME), run.samples()
    low, high = (
        samples[k].numbers[NAME][0, 0] * run.heat_partition[0] for k in (0, 2)
    )  # two pixels per wave
    assert found.budget["last step"][0] == pytest.approx(abs(high - low))
    assert "bandwidth" in found.unknown
    assert "continued from q_c" not in found.explain()


def test_a_map_cut_at_its_own_nyquist_wavenumber_is_the_map():
    grid = rs.Grid((12, 14), (12.0, 14.0))
    heights = np.random.default_rng(3).standard_normal(
        grid.shape
    )  # waves of the Nyquist wavenumber too
    np.testing.assert_allclose(
        band_limited(heights, grid, grid.shape, grid.nyquist), heights, atol=1e-12
    )
