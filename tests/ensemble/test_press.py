"""A measured map itself in contact: the very heights, errors by coarsening and by its quadrants, and a run folder."""

import math
import re
import warnings

import numpy as np
import pytest
from matplotlib.text import Text
from press_cases import GRID, SIDE, drawn_map, levelled, on_finer_points, write_scene
from stored_cases import member_path, split_members

import roughsim as rs
from roughsim.cli import main
from roughsim.ensemble.map_cells import cell_of, quadrants
from roughsim.surface.topography.periodic import band_limited, mirrored
from roughsim.surface.topography.reading import Topography
from roughsim.surface.topography.writing import encoded


@pytest.fixture(autouse=True)
def _long_waves():
    with warnings.catch_warnings():  # C(q) of a map goes on a little beyond its sides
        warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
        yield


@pytest.fixture(scope="module")
def surface():
    return drawn_map()


@pytest.fixture
def scene_file(capped_scene, tmp_path, surface):
    """A scene of one rough face that names the map, in µm."""
    return write_scene(tmp_path, surface, capped_scene)


def wave(grid, i, j):
    x, y = (np.arange(n) / n for n in grid.shape)
    return np.cos(2 * np.pi * (i * x[:, None] + j * y) + 0.7)  # of no symmetry


def test_waves_below_the_cut_off_stay_and_shorter_ones_go():
    low, high = wave(GRID, 3, -5), wave(GRID, 20, 2)
    q_max = 2 * math.pi / SIDE * 12
    for shape in ((48, 32), (96, 64), (192, 130), (50, 33)):
        found = band_limited(0.5 + 2.0 * low + high, GRID, shape, q_max)
        np.testing.assert_allclose(
            found, 0.5 + 2.0 * wave(rs.Grid(shape, GRID.lengths), 3, -5), atol=1e-13
        )


def test_mirror_images_go_on_without_a_step(surface):
    whole = mirrored(surface)
    assert whole.shape == (192, 128)
    np.testing.assert_array_equal(whole[:96, :64], surface)
    np.testing.assert_array_equal(whole, whole[::-1])
    np.testing.assert_array_equal(whole, whole[:, ::-1])


def test_the_quadrants_are_the_four_parts_each_with_its_mirror_images():
    grid = rs.Grid((67, 130), (0.67e-3, 2.6e-3))  # pixels of 10 and 20 µm; the last row is left out
    heights = np.random.default_rng(0).standard_normal(grid.shape)
    found = quadrants(Topography(heights, grid, periodic=True))
    parts = heights[:33, :65], heights[:33, 65:], heights[33:66, :65], heights[33:66, 65:]
    for cell, part in zip(found, parts, strict=True):
        np.testing.assert_array_equal(cell.heights[:33, :65], part)
        np.testing.assert_array_equal(cell.heights[33:, 65:], part[::-1, ::-1])
        assert cell.grid.lengths == pytest.approx((0.66e-3, 2.6e-3))
    assert cell_of(heights, grid, "tile").grid == grid


def test_a_tiled_map_is_pressed_as_its_own_heights_are(
    scene_file, surface, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr("roughsim.ensemble.progress.SILENCE", 0.01)
    run = rs.press(scene_file, tmp_path / "run", edges="tile")
    assert re.search(r"(?m)^0:00:\d\d round 1: \d+/\d+ members$", capsys.readouterr().err)
    assert "side by side" in run.reasons[0].text
    of_quadrants = next(reason for reason in run.reasons if reason.quantity == "quadrants")
    assert "mirror images" in of_quadrants.text  # they do not go on at their edges
    level = run.numerics.levels[run.numerics.of_column("capped")[-1]]
    heights = on_finer_points(levelled(surface), level.shape[0] // surface.shape[0])
    assert heights.shape == level.shape
    _, kept = next(run.fields("heights"))
    np.testing.assert_allclose(
        kept, heights, atol=1e-6 * np.ptp(heights)
    )  # stored in single precision
    # the chain by hand, with E* and conduction of the scene
    scene, grid = run.scene, rs.Grid(level.shape, GRID.lengths)
    solid = rs.Solid(scene.effective_modulus, scene.penetration_hardness)
    contact = rs.solve_contact(
        heights, grid, solid, nominal_pressure=scene.sliding.nominal_pressure, tolerance=1e-4
    )
    bodies = scene.conduction()
    sliding = rs.HeatSource(speeds=[35.0], friction_coefficient=scene.friction_coefficient(),
                         conductivity=bodies.conductivity, diffusivity=bodies.diffusivity)  # fmt: skip
    expected = rs.measure(contact, grid, sliding).flash_temperature[0]
    finest = run.samples()[-1]
    assert finest.numbers["flash_temperature"][0, scene.speeds.index(35.0)] == pytest.approx(
        expected, rel=1e-3
    )


def test_the_mean_is_the_map_and_the_scatter_that_of_its_quadrants(scene_file, tmp_path):
    run = rs.press(scene_file, tmp_path / "run")
    assert not run.drawn
    assert run.numerics.lengths == pytest.approx((2 * SIDE, SIDE * 4 / 3))  # with the mirror images
    first, *_ = run.numerics.of_column("quadrants")
    assert run.numerics.grid(first).lengths == pytest.approx(GRID.lengths)
    found = run.estimate("flash_temperature")
    alone = run.estimate("flash_temperature", "quadrants")
    values = run.values("flash_temperature")
    whole = values.value * run.heat_partition
    np.testing.assert_allclose(found.mean, whole, rtol=1e-12)
    finest = values.finest * run.heat_partition
    assert (finest[1:] != whole[1:]).all()  # there is an extrapolation
    np.testing.assert_allclose(found.bias, finest - whole, rtol=1e-9, atol=1e-12)
    moving = np.array(run.scene.speeds) > 0.0
    mean, apart = found.mean[moving], np.abs(alone.mean - found.mean)[moving]
    relative = alone.standard_error[moving] / alone.mean[moving]
    np.testing.assert_allclose(
        found.standard_error[moving] / mean, 1.2 * relative, rtol=1e-9
    )  # neighbours are alike
    np.testing.assert_allclose(found.budget["size"][moving], apart, rtol=1e-6)
    assert "scan" not in found.budget  # the map itself is pressed
    assert found.n == 4
    said = found.explain()
    assert "scatter of the four quadrants" in said
    assert "size: difference of the mean of the four quadrants from the map" in said
    assert "doubling cells" not in said  # of drawn surfaces


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_the_command_warns_as_run_does_but_not_of_the_error_of_a_spectrum(
    scene_file, tmp_path, capsys
):
    heights = np.load(tmp_path / "map.npy")
    np.save(tmp_path / "map.npy", 300 * heights)  # as if in another unit
    with pytest.raises(SystemExit) as ended:
        main(["press", str(scene_file), "-o", str(tmp_path / "run"), "--set", "sliding.speed=35"])
    assert ended.value.code == 0
    told = capsys.readouterr().out  # below the table
    assert "warning: rms slope = " in told
    assert "C(q) was measured on a scan" not in told
    page = rs.report(rs.open_run(tmp_path / "run"), tmp_path / "page.html").read_text()
    assert "rms slope = " in page
    assert "press the map" not in page


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_the_folder_opens_in_every_verb_and_goes_on_where_it_was_stopped(
    scene_file, tmp_path, capsys, drawn
):
    folder = tmp_path / "run"
    with pytest.raises(SystemExit) as ended:
        main(["press", str(scene_file), "-o", str(folder), "--set", "sliding.speed=35"])
    assert ended.value.code == 0
    printed = capsys.readouterr()
    assert ": the map itself" in printed.out
    assert "cell: 192 × 128 points, made periodic by its mirror images" in " ".join(
        printed.out.split()
    )
    assert "q_min" not in printed.err  # the cell has all that the map shows
    first = rs.open_run(folder)
    member_path(split_members(folder), 1, 0).unlink()
    again = rs.press(scene_file, folder, changes={"sliding.speed": 35})
    name = "flash_temperature"
    np.testing.assert_array_equal(again.estimate(name).mean, first.estimate(name).mean)
    assert rs.report(again, tmp_path / "page.html").exists()
    rs.compare(again).chart(tmp_path / "chart.png")
    for quantity, words in (
        ("spectrum", "measured, one realization"),
        ("heights", "the map and its mirror images"),
    ):
        with pytest.raises(SystemExit, match="0"):
            main(["plot", str(folder), quantity, "-o", str(tmp_path / "a.svg")])
        assert words in " ".join(text.get_text() for text in drawn[-1].findobj(Text))
    with pytest.raises(rs.RecordError, match="holds another scene: sliding.speed is"):
        rs.press(scene_file, folder)
    np.save(tmp_path / "map.npy", np.load(tmp_path / "map.npy")[::-1])
    with pytest.raises(
        rs.RecordError, match="holds another scene: (heights|surface.topography_digest|.*) is"
    ):
        rs.press(scene_file, folder, changes={"sliding.speed": 35})


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.5, pytest.param(2.0, marks=pytest.mark.slow)])
def test_a_target_below_the_statistical_error_needs_a_larger_map(scene_file, tmp_path, share):
    changes = {"sliding.speed": [1, 35]}
    found = rs.press(scene_file, tmp_path / "run", edges="tile", changes=changes).estimate(
        "flash_temperature"
    )
    statistical = (found.budget["statistical"] / found.mean).max()
    goal = share * statistical
    # the error of a mean over N maps side by side falls as √N: a map of n times both sides is n² maps
    maps = (statistical / goal) ** 2
    run = rs.press(
        scene_file,
        tmp_path / "run",
        edges="tile",
        changes=changes | {"ensemble.until": {"flash_temperature": goal}},
    )
    for text in (str(rs.compare(run)), str(rs.status(run))):
        line = " ".join(text.split())
        assert (f"needs a map {math.sqrt(maps):.2g} times as long and as wide" in line) == (
            share < 1.0
        )


@pytest.mark.slow
def test_an_open_run_follows_the_quadrants(scene_file, tmp_path):
    run = rs.press(scene_file, tmp_path / "run", edges="tile", changes={"sliding.speed": 35})
    assert run.estimate("flash_temperature").n == 4
    for level in run.numerics.of_column("quadrants"):
        member_path(split_members(run.folder), level, 3).unlink()
    shorter = rs.open_run(run.folder)
    assert shorter.independent == 3
    assert shorter.estimate("flash_temperature").n == 3
    rs.press(scene_file, run.folder, edges="tile", changes={"sliding.speed": 35})
    assert shorter.estimate("flash_temperature").n == 3
    shorter.refresh()
    assert shorter.estimate("flash_temperature").n == 4


@pytest.mark.slow
def test_another_map_of_the_same_spectrum_is_another_run(scene_file, tmp_path, surface):
    rs.press(scene_file, tmp_path / "run", edges="tile", changes={"sliding.speed": 35})
    np.save(
        tmp_path / "map.npy", -1e6 * surface
    )  # upside down: C(q) to the bit, so that only the heights tell
    with pytest.raises(rs.RecordError, match="holds another scene: heights is [0-9a-f]* there"):
        rs.press(scene_file, tmp_path / "run", edges="tile", changes={"sliding.speed": 35})


@pytest.mark.slow
def test_a_file_that_says_that_its_map_is_periodic_is_tiled(scene_file, tmp_path, surface):
    pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    (tmp_path / "map.nc").write_bytes(encoded(surface, GRID, ".nc"))
    lines = scene_file.read_text().replace("map.npy", "map.nc").splitlines()
    scene_file.write_text("\n".join(line for line in lines if not line.startswith("topography_")))
    run = rs.press(scene_file, tmp_path / "run", changes={"sliding.speed": 35})
    assert run.numerics.lengths == pytest.approx(GRID.lengths)


@pytest.mark.slow
@pytest.mark.statistical
def test_the_stated_error_of_mirrored_edges_holds_the_periodic_map(scene_file, tmp_path, surface):
    # tiled the periodic surface is exact; its mirror images have edges that it does not have
    tiled, mirror = (
        rs.press(scene_file, tmp_path / edges, edges=edges) for edges in ("tile", "mirror")
    )
    exact, found = (run.estimate("flash_temperature") for run in (tiled, mirror))
    assert (np.abs(found.mean - exact.mean) <= found.total_error).all()
    assert abs(found.mean[-1] / exact.mean[-1] - 1.0) < 0.1
