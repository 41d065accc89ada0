"""Snapshots of slides: their fields against the numbers of the slide and the faces, keeping, refusals."""

import shutil
from dataclasses import replace

import h5py
import numpy as np
import pytest
from slide_cases import sliding_scene
from stored_cases import read_member, split_members, write_member

import roughsim as rs
from roughsim.charts.plot import plot_run
from roughsim.results.snapshots import highest, pictured, read_snapshots
from roughsim.sliding import snapshots as snapshots_module
from roughsim.sliding.member import FRAMES, snapshot_steps
from roughsim.sliding.path import oblique_path
from roughsim.sliding.snapshots import in_blocks, snapshot_shape
from roughsim.store.member_files import fields_path, read_fields
from roughsim.surface.synthesis import synthesize

SLIDE = 1  # its level


@pytest.fixture(scope="module")
def snapshots(sliding_run):
    return read_snapshots(sliding_run, 0)


def test_the_temperature_of_the_maps_is_that_of_the_slide(snapshots):
    # ⟨Tσ⟩/⟨σ⟩ over the points of the maps, which are those of the slide; the curves come from products of spectra
    pressure = snapshots.maps.pressure.astype(float)
    assert snapshots.maps.distance == pytest.approx(snapshots.curves["slid_distance"], rel=1e-6)
    for k in range(2):
        flash = (snapshots.maps.temperature[k] * pressure).sum(axis=(1, 2)) / pressure.sum(
            axis=(1, 2)
        )
        assert flash == pytest.approx(snapshots.curves["slide_flash_temperature"][k], rel=1e-6)
    assert snapshots.maps.temperature.mean(axis=(2, 3)) == pytest.approx(
        0.0, abs=1e-4
    )  # above the background
    assert pressure.mean(axis=(1, 2)) == pytest.approx(9e7, rel=1e-6)
    assert (pressure > 0).mean(axis=(1, 2)) == pytest.approx(
        snapshots.curves["slide_contact_fraction"]
    )


def test_bodies_touch_where_the_faces_redrawn_stand_highest(sliding_run, snapshots):
    grid, spectrum = (
        sliding_run.numerics.grid(SLIDE),
        sliding_run.scene.faces[0].truncated(q_max=2.5e4),
    )
    keys = (SLIDE, 0), (SLIDE, 0, 1)
    resting, moving = (
        synthesize(
            spectrum,
            grid,
            np.random.default_rng(np.random.SeedSequence(sliding_run.seed, spawn_key=key)),
        )
        for key in keys
    )
    offsets = oblique_path(grid, 1e-3).offsets
    for place in (0, 7, 15):
        standing = np.roll(moving, -offsets[place + 1], axis=(0, 1))
        heights = resting + standing
        touching = snapshots.maps.pressure[place] > 0
        assert heights[touching].mean() > heights.mean() + 1.5 * heights.std()
        # the summits shown are the highest maxima of the face as it stands then
        points = np.rint(snapshots.moving_summits[place] / grid.spacing).astype(int)
        neighbours = [
            np.roll(standing, shift, axis=(0, 1))
            for shift in ((0, 1), (1, 0), (0, -1), (-1, -1), (1, -1))
        ]
        assert all((standing >= other)[tuple(points.T)].all() for other in neighbours)
        assert standing[tuple(points[0])] == standing.max()
    points = np.rint(snapshots.resting_summits / grid.spacing).astype(int)
    assert resting[tuple(points[0])] == resting.max()


def test_maps_of_a_larger_grid_are_means_over_blocks_under_the_same_summits(
    snapshots, tmp_path, monkeypatch
):
    monkeypatch.setattr(snapshots_module, "MOST_POINTS", 16)
    monkeypatch.setattr(snapshots_module, "LEAST_POINTS", 8)
    coarse = read_snapshots(rs.run(sliding_scene(), tmp_path / "run", max_realizations=1), 0)
    fine = snapshots.maps
    for mine, his in (
        (coarse.maps.pressure, fine.pressure),
        (coarse.maps.temperature, fine.temperature),
    ):
        means = (
            his[..., ::2, ::2] + his[..., 1::2, ::2] + his[..., ::2, 1::2] + his[..., 1::2, 1::2]
        ) / 4
        np.testing.assert_allclose(mine, means, rtol=1e-4, atol=1e-6 * np.abs(means).max())
    # the first point of a map of blocks of 2 × 2 lies between the first two points of the grid
    spacing = snapshots.grid.spacing[0]
    assert coarse.grid.spacing[0] == 2 * spacing
    assert coarse.resting_summits == pytest.approx(snapshots.resting_summits - spacing / 2)
    assert coarse.moving_summits == pytest.approx(snapshots.moving_summits - spacing / 2)


def test_a_flat_has_no_summits():
    assert highest(None).shape == (0, 2)


def test_snapshots_change_no_number_and_go_with_the_fields_that_are_kept(sliding_run, tmp_path):
    assert pictured(sliding_run) == [0]
    scene = sliding_scene()
    none = replace(scene, numerics=replace(scene.numerics, keep_fields=0))
    run = rs.run(none, tmp_path / "run", max_realizations=1)
    with_snapshots, without = (read_member(one.folder, SLIDE, 0) for one in (sliding_run, run))
    for name, values in with_snapshots.numbers.items():
        assert (without.numbers[name] == values).all()
    assert without.kept == {}
    with pytest.raises(
        ValueError, match="has no snapshots of realization 0; run .* with --keep-fields 1$"
    ):
        read_snapshots(run, 0)


def test_a_frozen_run_has_no_snapshots(capped_run):
    assert pictured(capped_run) == []
    with pytest.raises(
        ValueError, match='has no snapshots of realization 0; run a scene with history = "sliding"'
    ):
        read_snapshots(capped_run, 0)


def test_a_changed_byte_of_snapshots_is_noticed(sliding_run, tmp_path):
    path = fields_path(sliding_run.folder, SLIDE, 0)
    content = bytearray(path.read_bytes())
    with h5py.File(path) as file:
        content[file["film_temperature"].id.get_chunk_info(3).byte_offset + 20] ^= 1
    (tmp_path / path.name).write_bytes(content)
    with pytest.raises(rs.RecordError, match="SHA-256 does not match"):
        read_fields(tmp_path / path.name)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            lambda f: {name: f[name] for name in ("film_distance", "film_pressure")},
            r"is damaged \(it has no film_temperature\)",
        ),
        (
            lambda f: f | {"film_distance": 3 * f["film_distance"]},
            "holds snapshots of other speeds, distances",
        ),
        (
            lambda f: f | {"film_temperature": f["film_temperature"][:1]},
            "holds snapshots of other speeds, distances",
        ),
        (
            lambda f: f | {"film_pressure": f["film_pressure"][:, :8]},
            "is of another run: its speeds, levels or points",
        ),
    ],
)
def test_forged_snapshots_are_refused_by_name(sliding_run, tmp_path, change, told):
    split_members(shutil.copytree(sliding_run.folder, tmp_path / "run"))
    member = read_member(sliding_run.folder, SLIDE, 0)
    write_member(tmp_path / "run", replace(member, fields=change(member.fields)))
    with pytest.raises(rs.RecordError, match=f"L1-000000.h5 {told}"):
        read_snapshots(rs.open_run(tmp_path / "run"), 0)


def test_the_file_of_a_member_says_what_its_maps_are(sliding_run):
    with h5py.File(fields_path(sliding_run.folder, SLIDE, 0)) as file:
        temperature = file["film_temperature"]
        assert [axis[0] for axis in temperature.dims] == [
            file[name] for name in ("speed", "film_distance", "x", "y")
        ]
        assert {
            name: file[name].attrs["units"]
            for name in ("film_distance", "film_pressure", "film_temperature")
        } == {
            "film_distance": "m",
            "film_pressure": "Pa",
            "film_temperature": "K",
        }
        assert temperature.chunks == (1, 1, 32, 32)
        assert file["entry"].attrs["default"] == "fields"
        assert file["entry/fields"].attrs["signal"] == "film_pressure"


def test_snapshots_have_few_positions_and_the_last():
    grid = rs.Grid((512, 512), (4e-3, 4e-3))
    steps = snapshot_steps(oblique_path(grid, 16e-3))
    assert len(steps) <= FRAMES
    assert steps == sorted(steps)
    assert steps[-1] == round(16e-3 / oblique_path(grid, 16e-3).distance[1])
    assert 1 <= steps[0] <= 3


@pytest.mark.parametrize(
    ("points", "shown"), [(32, 32), (256, 256), (300, 150), (512, 256), (768, 256), (509, 509)]
)
def test_large_fields_are_averaged_in_whole_blocks(points, shown):
    assert snapshot_shape((points, 64)) == (shown, 64)  # 509 is prime


def test_blocks_are_means():
    field = np.arange(24.0).reshape(4, 6)
    assert in_blocks(field, (2, 2)).tolist() == [[4.0, 7.0], [16.0, 19.0]]


@pytest.mark.slow
def test_its_picture_has_four_positions_in_both_fields(sliding_run, tmp_path):
    text = plot_run(sliding_run, "snapshots", tmp_path / "one.svg", speed=1.0).read_text()
    for words in (
        "after 63.2 µm",
        "after 379 µm",
        "after 695 µm",
        "after 1.01 mm",
        "1 m/s",
        "realization 0",
        " (GPa)",
    ):
        assert words in text
    assert text.count("after ") == 4
    wrong = {
        "speed = 2 m/s: the slide has followed 1, 35 m/s": {"speed": 2.0},
        "has no snapshots of realization 1; run .* --keep-fields 2": {"realization": 1},
        "snapshots have a column of their own": {"column": "capped"},
        "zoom and side_by_side are for maps": {"side_by_side": True},
    }
    for told, words in wrong.items():
        with pytest.raises(ValueError, match=told):
            plot_run(sliding_run, "snapshots", tmp_path / "two.svg", **words)
    assert not (tmp_path / "two.svg").exists()
