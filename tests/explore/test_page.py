"""The page of a run: what its controls show, without a browser."""

import shutil
from copy import copy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tasks_at_once import Now

import roughsim as rs
from roughsim.explore import content
from roughsim.explore.content import WatchedRun, as_bytes

pytest.importorskip("bokeh")
from bokeh.document import Document
from bokeh.models import Div, PreText

from roughsim.explore import page as page_module
from roughsim.explore.layout import Layout
from roughsim.explore.page import Page


@pytest.fixture(scope="module")
def watched(capped_run):
    return WatchedRun(capped_run.folder)


@pytest.fixture
def opened(watched, monkeypatch):
    """Opens another folder of the same scene; its theory is known already."""
    monkeypatch.setattr(page_module, "LatestTask", Now)

    def open_page(folder):
        other = WatchedRun(folder)
        other.theory = watched.theory
        return Page(other, Document())

    return open_page


@pytest.fixture(scope="module")
def shared(watched):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page_module, "LatestTask", Now)
        yield Page(watched, Document())


@pytest.fixture
def page(shared):
    """A page as it opens."""
    layout = shared.layout
    layout.controls.colours_of.active = 0
    layout.x_range.update(start=0.0, end=2.0)
    layout.y_range.update(start=0.0, end=2.0)
    layout.controls.level.value, layout.controls.member.value = "2", "0"
    shared.choose(35.0, 0.0)
    shared.say("")
    return shared


def image(page, name="temperature"):
    return page.layout.maps[name].image.data


def pixels(field):
    """The image of a whole field; its limits are doubles, as those of the page: float32 rounds pixels differently."""
    return as_bytes(field, (float(field.min()), float(field.max())))


def temperature(run, speed, direction=0.0):
    return next(run.fields("temperature", speed=speed, direction=direction))[1]


def test_the_page_opens_with_the_fields_and_their_real_limits(page, capped_run):
    fields = {"pressure": next(capped_run.fields("pressure"))[1] / 1e9, "temperature": temperature(capped_run, 35.0)}
    heights = next(capped_run.fields("heights"))[1] * 1e6
    for name, field in fields.items():
        scale = page.layout.maps[name].scale
        assert (scale.low, scale.high) == pytest.approx((field.min(), field.max()), rel=1e-6)
        np.testing.assert_array_equal(image(page, name)["image"][0], pixels(field))
    scale = page.layout.maps["heights"].scale
    assert (-scale.low, scale.high) == pytest.approx((np.abs(heights).max(),) * 2, rel=1e-6)
    assert page.layout.state.text == "6 realizations; finished: all realizations are there"
    assert "35 m/s" in page.layout.maps["temperature"].figure.title.text
    assert "every point" in page.layout.maps["temperature"].figure.title.text
    assert image(page)["dw"] == pytest.approx([2.0])  # mm
    assert page.layout.problems.text == ""


def test_the_slider_shows_the_temperature_at_its_speed(page, capped_run):
    page.layout.controls.slider.value = -0.5
    field = temperature(capped_run, 10.0**-0.5)
    np.testing.assert_array_equal(image(page)["image"][0], pixels(field))
    page.choose(10.0**-0.5, 0.0)
    assert page.layout.controls.speed.value == "0.3162"
    bins = page.layout.distribution.bins.data
    contact = field[next(capped_run.fields("pressure"))[1] > 0]
    assert (bins["left"][0], bins["right"][-1]) == pytest.approx((contact.min(), contact.max()), rel=1e-6)
    assert (bins["area"] * (bins["right"] - bins["left"])).sum() == pytest.approx(100.0)  # per cent
    assert all(panel.chosen_speed.location == pytest.approx(10.0**-0.5) for panel in page.layout.curves.values())


def test_one_move_replaces_one_source_once(page):
    replaced = []
    page.layout.maps["temperature"].image.on_change("data", lambda attr, old, new: replaced.append(new))
    page.layout.controls.slider.value = 0.25
    assert len(replaced) == 1


def test_a_large_field_is_previewed_and_then_shown_whole(watched, monkeypatch):
    monkeypatch.setattr(page_module, "LatestTask", Now)
    monkeypatch.setattr(content, "PREVIEW", 64)
    page = Page(watched, Document())
    line = page.layout.line.source.data
    page.choose(1.0, 0.0, moving=True)
    assert image(page)["image"][0].shape == (64, 64)
    assert "preview" in page.layout.maps["temperature"].figure.title.text
    page.mark(0.5, 1.25)
    assert page.layout.line.source.data is line  # a preview is not read off
    page.choose(1.0, 0.0)
    assert image(page)["image"][0].shape == (128, 128)
    assert "1 m/s" in page.layout.maps["temperature"].figure.title.text
    assert "y = 1.25 mm" in page.layout.values.text
    page.choose(1.0, 0.0, moving=True)  # comes late: nothing is shown anew
    assert not page.temperature.preview
    page.choose(2.0, 0.0, moving=True)
    assert page.temperature.speed == 2.0
    assert page.temperature.preview


def test_the_temperature_of_a_member_that_was_left_is_not_shown(page):
    late = page.member.temperature(5.0, 0.0)
    page.layout.controls.level.value = "0"
    page.show_temperature(late)
    assert page.temperature.speed == 35.0
    assert page.temperature.member is page.member


def test_a_speed_chosen_while_a_member_is_read_is_the_one_that_is_shown(page):
    read, page.member = page.member, None
    page.choose(2.0, 0.0)
    page.show_member(read)
    assert (page.temperature.speed, page.temperature.preview) == (2.0, False)
    assert "2 m/s" in page.layout.maps["temperature"].figure.title.text
    assert page.layout.busy.text == ""


@pytest.mark.parametrize(("angle", "moved"), [(90, False), (-135, False), (30, True)])
def test_the_sliding_direction_is_that_of_its_slider(page, capped_run, angle, moved):
    page.layout.controls.angle.value = angle
    assert page.temperature.preview
    if not moved:
        page.layout.controls.angle.trigger("value_throttled", None, angle)  # the browser sets it, on release
        assert not page.temperature.preview
    field = temperature(capped_run, 35.0, np.radians(angle))
    np.testing.assert_array_equal(page.temperature.field, field)
    np.testing.assert_array_equal(image(page)["image"][0], pixels(field))
    assert page.layout.controls.angle.value == angle


@pytest.mark.parametrize(("direction", "degrees"), [(0.0, 0), (np.pi / 2, 90), (1.5 * np.pi, -90), (-7.0, -41)])
def test_the_slider_of_the_direction_shows_the_turn_that_is_least(page, direction, degrees):
    page.choose(35.0, direction)
    assert page.layout.controls.angle.value == degrees


def test_a_speed_can_be_written(page, capped_run):
    page.layout.controls.speed.value = "3.7"
    assert page.temperature.speed == 3.7
    assert 10**page.layout.controls.slider.value == pytest.approx(3.7, rel=0.03)
    field = temperature(capped_run, 3.7)
    np.testing.assert_array_equal(image(page)["image"][0], pixels(field))


@pytest.mark.parametrize(("text", "message"), [("fast", "is no number"), ("-1", "positive"), ("nan", "finite")])
def test_a_wrong_speed_is_refused_in_words(page, text, message):
    page.layout.controls.speed.value = text
    assert message in page.layout.problems.text
    assert page.temperature.speed == 35.0
    page.layout.controls.speed.value = "20000"  # beyond the slider, and none the less there
    assert page.temperature.speed == 20000.0
    assert page.layout.problems.text == ""


def test_zoom_is_linked_and_cuts_out_what_is_in_view(page, capped_run, monkeypatch):
    figures = [panel.figure for panel in page.layout.maps.values()]
    assert len({id(plot.x_range) for plot in figures}) == len({id(plot.y_range) for plot in figures}) == 1
    page.layout.x_range.update(start=0.5, end=1.0)  # mm of 2
    page.layout.y_range.update(start=1.0, end=1.25)
    for name in page.layout.maps:
        data = image(page, name)
        assert 0.48 <= data["x"][0] <= 0.5
        assert 1.0 <= data["x"][0] + data["dw"][0] <= 1.02
        assert 0.98 <= data["y"][0] <= 1.0
        assert 1.25 <= data["y"][0] + data["dh"][0] <= 1.27
    whole = page.layout.maps["temperature"].scale.high
    page.layout.controls.colours_of.active = 1  # colours of the view
    part = image(page)
    field = temperature(capped_run, 35.0)
    i, j = round((part["x"][0] + 1 / 128) * 64), round((part["y"][0] + 1 / 128) * 64)
    shape = part["image"][0].shape
    seen = field[i : i + shape[1], j : j + shape[0]]
    assert page.layout.maps["temperature"].scale.high == pytest.approx(seen.max())
    assert seen.max() <= whole
    np.testing.assert_array_equal(part["image"][0], as_bytes(seen, (seen.min(), seen.max())))


def test_a_coarse_view_says_that_it_is_averaged(page, monkeypatch):
    monkeypatch.setattr(page_module, "image_of", lambda *a: content.image_of(*a, pixels=32))
    page.draw_maps()
    for one in page.layout.maps.values():
        assert "averaged view, 4 × 4" in one.figure.title.text


def test_a_click_reads_off_the_full_field(page, capped_run):
    page.mark(0.5, 1.25)  # mm: point 32, 80
    fields = {name: next(capped_run.fields(name))[1] for name in ("heights", "pressure")}
    data = page.layout.line.source.data
    np.testing.assert_allclose(data["distance"], (np.arange(128) - 32) * 2.0 / 128, atol=1e-12)
    field = temperature(capped_run, 35.0)
    np.testing.assert_allclose(data["temperature"], field[:, 80], rtol=1e-6)
    np.testing.assert_array_equal(data["contact"], fields["pressure"][:, 80] > 0)
    text = page.layout.values.text
    assert f"T = {field[32, 80]:.5g} K" in text
    assert "x = 0.5 mm, y = 1.25 mm" in text
    np.testing.assert_allclose(data["heights"], fields["heights"][:, 80] * 1e6, rtol=1e-6)  # µm
    units = [panel.yaxis.axis_label for panel in page.layout.line.figures]
    assert units[0] == "h, µm"
    factor = {"σ, GPa": 1e-9, "σ, MPa": 1e-6, "σ, Pa": 1.0}[units[1]]
    np.testing.assert_allclose(data["pressure"], fields["pressure"][:, 80] * factor, rtol=1e-6)


def test_fields_that_were_not_kept_are_computed_again_with_a_bar(page, capped_run, monkeypatch):
    options, texts = dict(page.layout.controls.member.options), []
    assert options["0"] == "0"
    assert options["3"] == "3 (computed again)"
    page.layout.busy.on_change("text", lambda attr, old, new: texts.append(new))
    page.layout.controls.member.value = "3"
    assert "░" * 15 in texts[1]
    assert "these fields were not kept and are computed again, about" in texts[1]
    assert page.layout.problems.text == page.layout.busy.text == ""
    solved = rs.realize(capped_run.scene, capped_run.numerics, seed=capped_run.seed, level=2, index=3)
    np.testing.assert_array_equal(page.member.pressure, solved.contact.pressure.astype(np.float32))
    page.turn_bar()  # nothing is computed now
    assert page.layout.busy.text == ""
    page.layout.controls.member.value = "0"
    assert "computed again" not in texts[-2]


def test_the_bar_fills_with_the_time_that_has_passed(page, monkeypatch):
    monkeypatch.setattr(page_module.time, "monotonic", lambda: 130.0)
    page.began, page.usual = 100.0, 60.0
    page.turn_bar()
    assert page.layout.busy.text.startswith("█" * 10 + "░" * 10 + " ")
    assert page.layout.busy.text.endswith("about 30 s left")
    page.usual = 10.0
    page.turn_bar()
    assert page.layout.busy.text.endswith("any moment now")
    page.say("it failed")
    assert (page.began, page.layout.busy.text) == (None, "")


def test_another_level_shows_its_own_fields(page, capped_run):
    page.layout.controls.level.value = "0"
    field = next(capped_run.fields("temperature", "smoothed", speed=35.0))[1]
    np.testing.assert_array_equal(image(page)["image"][0], pixels(field))


def test_curves_show_bands_of_the_total_error_over_the_theory(page, capped_run):
    found = capped_run.estimate("flash_temperature", "capped")
    data = page.layout.curves["flash_temperature"].sources["capped"].data
    np.testing.assert_allclose(data["y"], found.mean[1:])
    np.testing.assert_allclose(data["high"] - data["y"], found.total_error[1:])
    width = page.layout.curves["flash_width"].sources["smoothed"].data
    np.testing.assert_allclose(width["y"], 1e6 * capped_run.estimate("flash_width", "smoothed").mean[1:])  # µm
    theory = page.layout.curves["pressure_correlation"].sources["theory"].data
    r, exact = page.watched.theory["pressure_correlation"]
    np.testing.assert_allclose(theory["x"], r * 1e6)  # µm
    np.testing.assert_allclose(theory["y"], exact * 1e-18)  # GPa²
    assert "flash_temperature" in page.layout.budgets["capped"].text


@pytest.mark.slow
def test_a_page_of_an_empty_run_fills_as_members_come(capped_run, opened, tmp_path):
    folder = Path(shutil.copytree(capped_run.folder, tmp_path / "copy"))
    aside = folder.with_name("aside")
    (folder / "realizations").rename(aside)
    (folder / "realizations").mkdir()
    page = opened(folder)
    assert page.layout.state.text.startswith("0 of about 6 realizations")
    assert page.layout.controls.member.disabled
    assert page.layout.curves["flash_temperature"].sources["theory"].data["y"].size > 0
    page.layout.controls.slider.value = 0.0  # nothing to show yet, and no error
    for index in (0, 1):
        for path in aside.glob(f"L?-{index:06d}.h5"):
            shutil.copy(path, folder / "realizations")
        page.look_for_news()
    assert page.layout.controls.member.value == "0"
    assert len(image(page)["image"]) == 1
    assert "2 of about 6 realizations" in page.layout.state.text
    assert len(page.layout.curves["flash_temperature"].sources["capped"].data["y"]) == 2
    assert page.temperature.speed == 1.0
    (folder / "realizations" / "L2-000001.h5").write_bytes(b"")
    page.watched.run = WatchedRun(folder).run
    page.look_for_news()
    assert "L2-000001.h5 is damaged" in page.layout.problems.text
    assert "2 of about 6 realizations" in page.layout.state.text  # as `status` counts


@pytest.mark.slow
def test_a_title_is_text_and_never_html(watched):
    run = copy(watched.run)
    for title in ("<img src=http://far.away/x>", "$$\\frac{$$", "[bold]x[/nope]"):
        run.scene = replace(run.scene, title=title)
        layout = Layout(run, 1.0)
        layout.problems.text = title
        for place in (layout.root.select_one({"name": "heading"}), layout.problems):
            assert place.text == title
        texts = list(layout.root.select({"type": Div}))
        assert len(texts) > 4
        assert all(place.disable_math for place in (*texts, *layout.root.select({"type": PreText})))
        assert all(place.render_as_text for place in texts)


@pytest.mark.slow
def test_a_field_of_half_the_cell_fills_the_view_and_says_its_size(capped_scene, tmp_path, monkeypatch):
    half = {"column": "capped", "shape": (32, 32), "q_max": 5e4, "cell": "half"}
    levels = ({"column": "capped", "shape": (64, 64), "q_max": 5e4}, half, half | {"shape": (64, 64), "q_max": 1e5})
    scene = replace(capped_scene, numerics=replace(capped_scene.numerics, levels=levels))
    run = rs.run(scene, tmp_path / "run", max_realizations=2)
    monkeypatch.setattr(page_module, "LatestTask", Now)
    page = Page(WatchedRun(run.folder), Document())
    page.look_for_news()
    layout = page.layout

    def view():
        return [(axis.start, axis.end, axis.reset_end, *axis.bounds) for axis in (layout.x_range, layout.y_range)]

    def title():
        return layout.maps["pressure"].figure.title.text

    assert view() == [pytest.approx((0.0, 2.0, 2.0, -0.04, 2.04))] * 2  # mm
    assert "half" not in title()
    layout.controls.level.value = "2"
    layout.controls.member.value = "0"
    assert view() == [pytest.approx((0.0, 1.0, 1.0, -0.02, 1.02))] * 2
    assert title().startswith("Contact pressure, GPa, half the cell: 1 × 1 mm")
    pressure = run.field(2, 0, "pressure")
    limits = float(pressure.min()), float(pressure.max())
    np.testing.assert_array_equal(image(page, "pressure")["image"][0], as_bytes(pressure, limits))
    assert image(page, "pressure")["dw"] == [pytest.approx(1.0)]
    layout.x_range.end = 0.5  # a view that was chosen stays for fields of the same cell
    page.choose_member()
    assert layout.x_range.end == 0.5
    layout.controls.level.value = "0"
    assert view() == [pytest.approx((0.0, 2.0, 2.0, -0.04, 2.04))] * 2
    assert "half" not in title()
