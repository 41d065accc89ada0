"""Snapshots of two sliding bodies on the page, without a browser."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from slide_cases import sliding_scene
from stored_cases import member_path, split_members
from tasks_at_once import Now

import roughsim as rs
from roughsim.explore.content import WatchedRun, as_bytes
from roughsim.results.snapshots import read_snapshots

pytest.importorskip("bokeh")
from bokeh.document import Document

from roughsim.explore.page import Page


@pytest.fixture(scope="module")
def snapshots(sliding_run):
    return read_snapshots(sliding_run, 0)


@pytest.fixture(scope="module")
def shared_view(sliding_run):
    return Page(WatchedRun(sliding_run.folder), Document(), Now).snapshots


@pytest.fixture
def view(shared_view, snapshots):
    """Snapshots as on a page that has just opened."""
    shared_view.play.active = False
    shared_view.speed.value = "1"
    shared_view.slider.disabled = True
    shared_view.show_snapshots(snapshots)
    return shared_view


def pixels(frames, place):
    return as_bytes(frames[place], (float(frames.min()), float(frames.max())))


def test_it_opens_at_the_last_position_of_the_fastest_speed(opened, sliding_run, snapshots):
    view = opened(sliding_run.folder).snapshots
    assert (view.slider.value, view.slider.end) == (15, 15)
    assert view.member.options == ["0"]
    maps = {"pressure": snapshots.maps.pressure, "temperature": snapshots.maps.temperature[1]}
    for name, frames in maps.items():
        np.testing.assert_array_equal(view.maps[name].image.data["image"][0], pixels(frames, 15))
    flash = snapshots.curves["slide_flash_temperature"][1, -1]
    assert view.text.text.startswith(
        f"After 1.01 mm at 35 m/s: T_flash = {flash:.4g} K above a background of"
    )
    assert view.cursor.location == pytest.approx(1.0106, rel=1e-4)


def test_the_slider_moves_the_moving_face_and_the_cursor_and_not_the_face_at_rest(view, snapshots):
    at_rest = dict(view.at_rest.data)
    before = view.riding.data["x"]
    view.slider.value = 4
    np.testing.assert_array_equal(
        view.maps["pressure"].image.data["image"][0], pixels(snapshots.maps.pressure, 4)
    )
    assert view.cursor.location == pytest.approx(1e3 * snapshots.maps.distance[4])
    # eleven pixels back; the cell is periodic
    step = 2.0 / 32
    moved = (view.riding.data["x"] - before + step / 2) % 2.0 - step / 2
    assert moved == pytest.approx(11 * step)
    assert all((view.at_rest.data[axis] == at_rest[axis]).all() for axis in "xy")


def test_another_speed_shows_its_own_temperature_at_the_same_position(view, snapshots):
    view.slider.value = 7
    view.speed.value = "0"
    assert view.slider.value == 7
    temperature = view.maps["temperature"].image.data["image"][0]
    np.testing.assert_array_equal(temperature, pixels(snapshots.maps.temperature[0], 7))
    assert "at 1 m/s" in view.text.text


def test_a_speed_that_ends_earlier_has_fewer_positions(view, snapshots):
    temperature = snapshots.maps.temperature.copy()
    temperature[0, 6:] = np.nan
    view.show_snapshots(replace(snapshots, maps=replace(snapshots.maps, temperature=temperature)))
    assert view.slider.end == 15
    view.speed.value = "0"
    assert (view.slider.value, view.slider.end) == (5, 5)
    shown = view.maps["temperature"].image.data["image"][0]
    np.testing.assert_array_equal(shown, pixels(temperature[0, :6], 5))
    view.speed.value = "1"
    assert (view.slider.value, view.slider.end) == (5, 15)


def test_the_curves_are_those_of_the_member(view, snapshots):
    for k, source in enumerate(view.lines):
        assert source.data["y"] == pytest.approx(snapshots.curves["slide_flash_temperature"][k])
        assert source.data["frozen"] == pytest.approx(
            snapshots.curves["slide_frozen_flash_temperature"][k]
        )
        assert source.data["x"][-1] == pytest.approx(1.0106, rel=1e-4)  # mm


def test_it_plays_from_the_start_to_the_end_and_stops(view):
    view.play.active = True  # from the end it begins anew
    assert view.slider.value == 0
    assert (
        len(view.document.session_callbacks) == 3
    )  # those of the page, for news and for its bar, and this
    for _ in range(40):
        if view.play.active:
            view.turn()
    assert view.slider.value == view.slider.end
    assert not view.play.active
    assert len(view.document.session_callbacks) == 2
    view.slider.value = 3
    view.play.active = True
    view.play.active = False
    assert view.slider.value == 3
    assert "play" in view.play.label


def test_a_run_that_kept_no_maps_says_how_to_keep_them(tmp_path):
    scene = sliding_scene()
    rs.run(
        replace(scene, numerics=replace(scene.numerics, keep_fields=0)),
        tmp_path / "run",
        max_realizations=1,
    )
    view = Page(WatchedRun(tmp_path / "run"), Document(), Now).snapshots
    assert view.member.disabled
    assert (
        view.text.text == "No slide has kept its maps yet: the first --keep-fields realizations do."
    )
    view.speed.value = "0"  # nothing to show
    view.slider.value = 1
    assert view.snapshots is None


def test_snapshots_come_up_when_their_slide_is_there(sliding_run, tmp_path):
    shutil.copytree(sliding_run.folder, tmp_path / "run")
    split_members(tmp_path / "run")
    late = [member_path(tmp_path / "run", level, 0) for level in (0, 1)]
    for path in late:
        path.rename(tmp_path / path.name)
    page = Page(WatchedRun(tmp_path / "run"), Document(), Now)
    assert page.snapshots.member.options == []
    page.look_for_news()
    for path in late:
        (tmp_path / path.name).rename(path)
    page.look_for_news()
    assert page.snapshots.member.options == ["0"]
    assert page.snapshots.text.text.startswith("After 1.01 mm at 35 m/s")
