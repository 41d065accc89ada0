"""What the page of a run computes, without the page: averaged views, previews, lines, distributions, growth, words."""

import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from threading import Event

import numpy as np
import pytest
from scipy.special import j0

import roughsim as rs
from roughsim import fourier, prediction
from roughsim.charts.maps import palette
from roughsim.cli import main
from roughsim.explore import curves, views, words
from roughsim.explore.library import Latest, Library
from roughsim.explore.specimen import along, distribution, line_through, load, nearest
from roughsim.show.units import plus_minus
from roughsim.store.claims import Claims

GRID = rs.Grid((12, 10), (6e-3, 2e-3))  # spacing 0.5 mm and 0.2 mm
FIELD = np.random.default_rng(1).normal(size=GRID.shape)


def everything(grid):
    return (0.0, grid.lengths[0]), (0.0, grid.lengths[1])


@pytest.fixture
def copied(capped_run, tmp_path):
    """A run folder of one's own, to be damaged."""
    return Path(shutil.copytree(capped_run.folder, tmp_path / "copy"))


# views


def test_a_view_of_few_points_shows_every_point():
    part = views.part_in_view(GRID, *everything(GRID))
    assert not part.averaged
    np.testing.assert_array_equal(views.averaged(FIELD, part), FIELD)
    assert views.box_of(GRID, part) == pytest.approx((-0.25e-3, -0.1e-3, 6e-3, 2e-3))  # points are centred


def test_an_averaged_view_holds_the_means_of_blocks():
    part = views.part_in_view(GRID, *everything(GRID), pixels=5)
    assert part.step == (3, 2)
    image = views.averaged(FIELD, part)
    assert image.shape == (4, 5)
    for i in range(4):
        for j in range(5):
            assert image[i, j] == pytest.approx(FIELD[3 * i : 3 * i + 3, 2 * j : 2 * j + 2].mean(), rel=1e-12)


def test_blocks_that_do_not_divide_the_cell_keep_their_places():
    part = views.part_in_view(GRID, *everything(GRID), pixels=3)
    assert part.step == (4, 4)  # 10 = 4 + 4 + 2
    image, box = views.averaged(FIELD, part), views.box_of(GRID, part)
    assert image[1, 2] == pytest.approx(FIELD[4:8, 8:10].mean(), rel=1e-12)
    assert box.height == pytest.approx(12 * 0.2e-3)  # the last block reaches beyond the cell: no block is squeezed


@pytest.mark.parametrize("seed", range(30))
def test_a_part_covers_its_view_with_few_pixels_on_a_fixed_raster(seed):
    rng = np.random.default_rng(seed)
    shape = tuple(int(n) for n in rng.integers(1, 5000, 2))
    grid = rs.Grid(shape, (4e-3, 3e-3))
    ends = [tuple(rng.uniform(-0.2, 1.2, 2) * length) for length in grid.lengths]
    part = views.part_in_view(grid, *ends)
    box = views.box_of(grid, part)
    for axis in (0, 1):
        side, step, d = part[axis], part.step[axis], grid.spacing[axis]
        count = -(-(side.stop - side.start) // step)
        assert 1 <= count <= views.PIXELS
        assert side.start % step == 0
        low, high = (np.clip(end, 0.0, (grid.shape[axis] - 0.5) * d) for end in sorted(ends[axis]))
        assert box[axis] <= low + 1e-12
        assert box[axis] + box[2 + axis] >= high - 1e-12
    assert max(views.averaged(np.zeros(shape, np.float32), part).shape) <= views.PIXELS


def test_bytes_follow_the_limits_and_screens_see_y_upwards():
    image = np.array([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])  # x, y
    shown = views.as_bytes(image, (0.0, 5.0))
    np.testing.assert_array_equal(shown, [[0, 153], [51, 204], [102, 255]])  # rows are y
    np.testing.assert_array_equal(views.as_bytes(image, (2.0, 3.0)), [[0, 255], [0, 255], [0, 255]])
    assert views.as_bytes(image, (4.0, 4.0)).max() == 0
    assert shown.dtype == np.uint8
    assert shown.flags.c_contiguous


def test_colours_are_those_of_the_printed_maps():
    assert len(palette("temperature")) == 256
    assert palette("pressure")[0] == "#ffffff"
    assert palette("heights")[0][1:3] < palette("heights")[255][1:3]  # blue below, red above


# previews


@pytest.mark.parametrize("shape", [(1, 1), (64, 48), (96, 31), (33, 64)])
def test_the_preview_has_the_waves_of_the_field(shape, monkeypatch):
    monkeypatch.setattr(views, "PREVIEW", 32)
    grid = rs.Grid(shape, (3e-3, 2e-3))
    x, y = np.meshgrid(*(np.arange(n) * d for n, d in zip(shape, grid.spacing, strict=True)), indexing="ij")
    kx, ky = (0, 0) if shape == (1, 1) else (7, 5)

    def wave(x, y):
        return 2.0 + np.cos(2 * np.pi * (kx * x / 3e-3 + ky * y / 2e-3) + 0.4)

    preview, target = views.preview_of(wave(x, y), grid), views.preview_grid(grid)
    assert max(target.shape) <= 32
    places = np.meshgrid(*(np.arange(n) * d for n, d in zip(target.shape, target.spacing, strict=True)), indexing="ij")
    np.testing.assert_allclose(preview, wave(*places), atol=1e-12)


def test_long_waves_of_the_previewed_temperature_are_those_of_the_whole(capped_run, monkeypatch):
    # the temperature is linear in the heat, wave by wave
    monkeypatch.setattr(views, "PREVIEW", 64)
    one = load(capped_run, 2, 0)
    assert not one.is_small
    for speed, direction in ((0.1, 0.0), (35.0, 0.7), (100.0, -2.0)):
        whole, preview = one.temperature(speed, direction), one.temperature_preview(speed, direction)
        assert preview.shape == (64, 64)
        np.testing.assert_allclose(
            fourier.forward(preview)[1:32, :32], fourier.forward(whole)[1:32, :32], atol=2e-7 * np.abs(whole).max()
        )


# a member


def test_the_temperature_of_the_page_is_that_of_the_run(capped_run):
    one = load(capped_run, 2, 0)
    assert one.is_small
    for speed, direction in ((0.1, 0.0), (35.0, 1.2)):
        index, field = next(capped_run.fields("temperature", speed=speed, direction=direction))
        assert index == 0
        np.testing.assert_array_equal(one.temperature(speed, direction), field)
        np.testing.assert_array_equal(one.temperature_preview(speed, direction), field)


def test_a_field_that_was_not_kept_says_how_to_come_by_it(capped_run):
    with pytest.raises(ValueError, match=r"fields of realization 3 at level 2; .*--keep-fields 4.*index=3"):
        load(capped_run, 2, 3)


def test_the_distribution_has_the_mean_and_the_flash_temperature_of_the_contact():
    temperature = np.array([[1.0, 2.0], [4.0, 100.0]])
    found = distribution(temperature, np.array([[1.0, 1.0], [2.0, 0.0]]), bins=3)
    assert found.flash_temperature == pytest.approx((1 + 2 + 8) / 4)
    assert found.mean_temperature == pytest.approx(7 / 3)
    assert found.max_temperature == 4.0  # 100 K is outside the contact
    np.testing.assert_allclose(found.edges, [1, 2, 3, 4])
    np.testing.assert_allclose(found.area, [1 / 3, 1 / 3, 1 / 3])
    np.testing.assert_allclose(found.heat, [0.25, 0.25, 0.5])


@pytest.mark.parametrize("values", [[[3.0]], [[1.0, 5.0, 2.0]]])
def test_a_distribution_adds_up_to_one(values):
    found = distribution(np.array(values), np.ones_like(values))
    for density in (found.area, found.heat):
        assert (density * np.diff(found.edges)).sum() == pytest.approx(1.0)


def test_no_contact_has_no_distribution():
    found = distribution(np.ones((3, 3)), np.zeros((3, 3)))
    assert found.area.size == found.edges.size == 0
    assert np.isnan(found.flash_temperature)


def test_a_click_finds_the_point_whose_pixel_it_hits():
    assert nearest(GRID, 1.24e-3, 0.31e-3) == (2, 2)
    assert nearest(GRID, 1.26e-3, 0.29e-3) == (3, 1)
    assert nearest(GRID, -1.0, 9.0) == (0, 9)


@pytest.mark.parametrize(("direction", "axis", "sign"), [(0.0, 0, 1), (np.pi, 0, -1), (np.pi / 2, 1, 1)])
def test_a_line_along_an_axis_meets_each_point_once(direction, axis, sign):
    line = line_through(GRID, (4, 7), direction)
    running, fixed = (line.i, line.j) if axis == 0 else (line.j, line.i)
    np.testing.assert_array_equal(running, np.arange(GRID.shape[axis])[::sign])
    assert set(fixed.tolist()) == {(7, 4)[axis]}
    d = GRID.spacing[axis]
    np.testing.assert_allclose(line.distance, sign * (running - (4, 7)[axis]) * d, atol=1e-12)


@pytest.mark.parametrize("direction", [0.3, 1.0, 2.2, -0.9, -3.0])
def test_an_oblique_line_stays_within_half_a_point_and_ends_at_the_sides(direction):
    point = (4, 7)
    line = line_through(GRID, point, direction)
    place = np.array(point)[:, None] * np.array(GRID.spacing)[:, None]
    exact = (place + np.array([[np.cos(direction)], [np.sin(direction)]]) * line.distance) / np.array(GRID.spacing)[
        :, None
    ]
    assert np.abs(np.stack([line.i, line.j]) - exact).max() <= 0.5 + 1e-9
    assert (line.i[line.distance == 0.0], line.j[line.distance == 0.0]) == point
    beyond = np.array([line.distance[0] - 0.2e-3, line.distance[-1] + 0.2e-3])
    ends = np.array(point)[:, None] + np.array([[np.cos(direction)], [np.sin(direction)]]) * beyond / np.array(
        GRID.spacing
    ).reshape(2, 1)
    outside = (ends < -1e-9) | (ends > np.array(GRID.shape).reshape(2, 1) - 1 + 1e-9)
    assert outside.any(axis=0).all()  # one step further is outside


def test_values_on_a_line_are_those_of_the_field():
    line = line_through(GRID, (4, 7), 0.0)
    values = along(line, heights=FIELD, temperature=None)
    np.testing.assert_array_equal(values["heights"], FIELD[:, 7])
    assert np.isnan(values["temperature"]).all()


# curves


def test_measured_curves_are_the_estimates(capped_run):
    found = curves.measured_curves(capped_run)
    assert set(found) == {"smoothed", "capped"}
    for column in found:
        for name in curves.OVER_SPEED:
            estimate = capped_run.estimate(name, column)
            np.testing.assert_array_equal(found[column][name].x, [0.1, 35.0])  # rest has no place on a log axis
            np.testing.assert_array_equal(found[column][name].mean, estimate.mean[1:])
            np.testing.assert_array_equal(found[column][name].error, estimate.total_error[1:])
        curve = found[column][curves.CORRELATION]
        sample = capped_run.samples(column)[-1]
        exact = sample.spectrum.mean(0) @ j0(np.outer(sample.wavenumber, curve.x[[0, 40, -1]]))
        np.testing.assert_allclose(curve.mean[[0, 40, -1]], exact, rtol=1e-9, atol=1e-9 * exact[0])


def test_theory_curves_pass_through_the_predictions_with_the_share(capped_run):
    found, scene = curves.theory_curves(capped_run), capped_run.scene
    whole = prediction.predictions(scene)
    for name in curves.OVER_SPEED:
        x, line = found[name]
        share = 0.9 if name == "flash_temperature" else 1.0
        at = np.exp(np.interp(np.log([0.1, 35.0]), np.log(x), np.log(line)))
        np.testing.assert_allclose(at, share * whole[name][1:], rtol=2e-3)  # interpolated between 20 points a decade
    assert found[curves.CORRELATION][1][0] == pytest.approx(whole["pressure_variance"][0], rel=1e-6)


def test_speeds_reach_a_decade_beyond_the_scene(capped_scene):
    assert curves.speed_range(capped_scene) == pytest.approx((1e-2, 1e3))
    resting = replace(capped_scene, sliding=replace(capped_scene.sliding, speed=(0.0,)))
    assert curves.speed_range(resting) == pytest.approx((0.1, 10.0))


# words


def test_the_budget_names_every_observable_with_the_numbers_of_the_estimate(capped_run):
    text = words.budget_of(capped_run, "capped")
    for name in ("flash_temperature, K", "slope_length, µm", "correlation_radius_0, µm", "statistical", "n = 6"):
        assert name in text
    flash = capped_run.estimate("flash_temperature", "capped")
    row = next(line for line in text.splitlines() if line.split()[:1] == ["35"])
    assert " ± ".join(row.split()[1:3]) == plus_minus(flash.mean[2], flash.total_error[2], flash.unknown_at(2))


def test_the_state_counts_and_says_that_the_run_is_finished(capped_run):
    assert words.state_of(capped_run) == "6 realizations; finished"
    assert "L2: capped, 128 × 128 points" in words.scene_of(capped_run)


# a run that is empty, grows, or is damaged


@pytest.fixture
def empty(copied):
    """The folder of a run of which nothing is there yet, and its members beside it."""
    aside = copied.with_name("aside")
    (copied / "realizations").rename(aside)
    (copied / "realizations").mkdir()
    return copied, aside


def arrive(folder, aside, index):
    for path in sorted(aside.glob(f"L?-{index:06d}.h5")):
        shutil.copy(path, folder / "realizations")


def test_an_empty_run_shows_its_scene_and_theory(empty):
    library = Library(empty[0])
    summary = library.summary()
    assert summary.measured == {}
    assert summary.kept == {0: [], 1: [], 2: []}
    assert library.state() == "no realization yet; not being computed now"
    assert summary.budget["capped"].startswith("No realization yet")
    assert library.theory["flash_temperature"][1].min() > 0.0
    assert summary is library.summary()


def test_a_growing_run_is_followed(empty):
    folder, aside = empty
    library = Library(folder)
    before = library.summary()
    arrive(folder, aside, 0)
    one = library.summary()
    assert one is not before
    assert one.kept[2] == [0]
    assert np.isinf(one.measured["capped"]["flash_temperature"].error).all()  # one realization has no scatter
    with Claims(folder, renewal=0.02):
        assert f"being computed by process {os.getpid()}" in library.state()
    arrive(folder, aside, 1)
    assert library.summary().sound[2] == [0, 1]
    assert np.isfinite(library.summary().measured["capped"]["flash_temperature"].error).all()
    assert sorted(path.name for path in folder.iterdir()) == ["realizations", "run.json", "scene.toml"]


def test_a_damaged_file_is_named_and_the_others_are_shown(copied):
    path = copied / "realizations" / "L2-000003.h5"
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(rs.RecordError, match="L2-000003"):
        rs.open_run(copied)
    library = Library(copied)
    summary = library.summary()
    assert summary.sound[2] == [0, 1, 2, 4, 5]
    (line,) = summary.problems
    assert "L2-000003.h5 is damaged" in line
    assert "other realizations are shown" in line
    path.write_bytes(whole)  # mended: counted again
    assert library.summary().sound[2] == [0, 1, 2, 3, 4, 5]
    assert library.summary().problems == []


def test_a_file_damaged_while_the_page_is_open_is_named(empty):
    folder, aside = empty
    for index in (0, 1, 2):
        arrive(folder, aside, index)
    library = Library(folder)
    assert library.summary().problems == []
    (folder / "realizations" / "L2-000001.h5").write_bytes(b"no HDF5")
    arrive(folder, aside, 3)
    assert "L2-000001.h5 is damaged" in library.summary().problems[0]
    assert library.summary().sound[2] == [0, 2, 3]


def test_damaged_fields_are_named(copied):
    path = copied / "realizations" / "L2-000000.h5"
    content = bytearray(path.read_bytes())
    content[-5000] ^= 0xFF
    path.write_bytes(bytes(content))
    with pytest.raises(rs.RecordError, match=r"L2-000000.h5 is damaged"):
        Library(copied).specimen(2, 0)


def test_the_last_members_are_remembered(capped_run):
    library = Library(capped_run.folder)
    first = library.specimen(2, 0)
    assert library.specimen(2, 0) is first
    library.specimen(1, 0)
    library.specimen(0, 0)
    assert library.specimen(2, 0) is not first


def test_only_the_latest_of_many_tasks_is_done():
    shown, failures = [], []
    latest = Latest(lambda show: show(), failures.append)
    started, go = Event(), Event()

    def slow():
        started.set()
        go.wait(5)
        return "first"

    latest.ask(slow, shown.append)
    started.wait(5)
    for k in range(20):
        latest.ask(lambda k=k: k, shown.append)
    go.set()
    latest._pool.shutdown(wait=True)
    assert shown == ["first", 19]  # what had begun is shown, what waited is dropped but for the last
    assert failures == []


def test_a_failing_task_is_reported():
    failures = []
    latest = Latest(lambda show: show(), failures.append)
    latest.ask(lambda: 1 / 0, print)
    latest._pool.shutdown(wait=True)
    assert isinstance(failures[0], ZeroDivisionError)


# the command


def refused(words_, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["explore", *words_])
    assert ended.value.code == 1
    error = capsys.readouterr().err
    assert error.startswith("roughsim: ")
    assert error.count("\n") == 1
    return error


def test_the_help_never_imports_bokeh():
    code = (
        "import sys; from roughsim.cli import main\n"
        "for words in (['--help'], ['explore', '--help']):\n"
        "    try: main(words)\n"
        "    except SystemExit: pass\n"
        "print({'bokeh', 'tornado', 'numpy'} & set(sys.modules))"
    )
    root = str(Path(rs.__file__).parents[1])
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root)
    assert "--no-browser" in done.stdout
    assert done.stdout.endswith("set()\n")


def test_a_missing_extra_says_the_pip_line(capped_run, capsys, monkeypatch):
    monkeypatch.setattr("roughsim.explore.find_spec", lambda name: None)
    assert "pip install 'roughsim[explore]'" in refused([str(capped_run.folder)], capsys)


def test_a_folder_that_is_no_run_is_refused(tmp_path, capsys):
    pytest.importorskip("bokeh")
    assert f"{tmp_path} is no run" in refused([str(tmp_path), "--no-browser"], capsys)
    assert "does not exist" in refused([str(tmp_path / "none"), "--no-browser"], capsys)
