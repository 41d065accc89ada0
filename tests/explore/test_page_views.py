"""The page of a run: parts of fields, fields that were not kept, and runs that are under way or odd."""

import shutil
import time
from copy import copy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from page_cases import image, pixels, temperature
from stored_cases import split_members
from tasks_at_once import Now

import roughsim as rs
from roughsim.explore.content import WatchedRun, as_bytes, image_of

pytest.importorskip("bokeh")
from bokeh.document import Document
from bokeh.models import Div, PreText

from roughsim.explore.layout import Layout
from roughsim.explore.page import Page


def test_zoom_is_linked_and_cuts_out_what_is_in_view(page, capped_run):
    figures = [panel.figure for panel in page.layout.maps.values()]
    assert (
        len({id(plot.x_range) for plot in figures})
        == len({id(plot.y_range) for plot in figures})
        == 1
    )
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


def test_a_coarse_view_says_that_it_is_averaged(page):
    field, grid = page.member.pressure, page.member.grid
    whole = tuple((0.0, length) for length in grid.lengths)
    panel = page.layout.maps["pressure"]
    panel.show(image_of(field, grid, whole, None, pixels=32), page.layout.factor, "")
    assert "(means of 4 × 4)" in panel.figure.title.text


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
    assert units[0] == "h (µm)"
    factor = {"σ (GPa)": 1e-9, "σ (MPa)": 1e-6, "σ (Pa)": 1.0}[units[1]]
    np.testing.assert_allclose(data["pressure"], fields["pressure"][:, 80] * factor, rtol=1e-6)


def test_fields_that_were_not_kept_are_computed_again_with_a_bar(page, capped_run):
    options, texts = dict(page.layout.controls.member.options), []
    assert options["0"] == "0"
    assert options["3"] == "3 (computed again)"
    page.layout.busy.on_change("text", lambda attr, old, new: texts.append(new))
    page.layout.controls.member.value = "3"
    assert "░" in texts[1]
    assert "these fields were not kept and are computed again, about" in texts[1]
    assert page.layout.problems.text == page.layout.busy.text == ""
    solved = rs.realize(
        capped_run.scene, capped_run.numerics, seed=capped_run.seed, level=2, index=3
    )
    np.testing.assert_array_equal(page.member.pressure, solved.contact.pressure.astype(np.float32))
    page.turn_bar()  # nothing is computed now
    assert page.layout.busy.text == ""
    page.layout.controls.member.value = "0"
    assert "computed again" not in texts[-2]


def test_the_bar_fills_with_the_time_that_has_passed(page):
    page.began, page.usual = time.monotonic() - 30.0, 60.0
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
    np.testing.assert_allclose(
        width["y"], 1e6 * capped_run.estimate("flash_width", "smoothed").mean[1:]
    )  # µm
    theory = page.layout.curves["pressure_correlation"].sources["theory"].data
    r, exact, _ = page.watched.theory(None)["pressure_correlation"]
    np.testing.assert_allclose(theory["x"], r * 1e6)  # µm
    np.testing.assert_allclose(theory["y"], exact * 1e-18)  # GPa²
    assert "flash_temperature" in page.layout.budgets["capped"].text


@pytest.mark.slow
def test_a_page_of_an_empty_run_fills_as_members_come(capped_run, opened, tmp_path):
    folder = split_members(Path(shutil.copytree(capped_run.folder, tmp_path / "copy")))
    aside = folder.with_name("aside")
    (folder / "members").rename(aside)
    (folder / "members").mkdir()
    page = opened(folder)
    assert page.layout.state.text.startswith("0 realizations")
    assert page.layout.controls.member.disabled
    assert page.layout.curves["flash_temperature"].sources["theory"].data["y"].size > 0
    page.layout.controls.slider.value = 0.0  # nothing to show yet, and no error
    for index in (0, 1):
        for path in aside.glob(f"L?-{index:06d}.h5"):
            shutil.copy(path, folder / "members")
        page.look_for_news()
    assert page.layout.controls.member.value == "0"
    assert len(image(page)["image"]) == 1
    assert page.layout.state.text.startswith("2 realizations")
    assert len(page.layout.curves["flash_temperature"].sources["capped"].data["y"]) == 2
    assert page.temperature.speed == 1.0
    (folder / "members" / "L2-000001.h5").write_bytes(b"")
    page.watched.run = WatchedRun(folder).run
    page.look_for_news()
    assert "L2-000001.h5 is damaged" in page.layout.problems.text
    assert page.layout.state.text.startswith("2 realizations")  # as `status` counts


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
def test_a_field_of_half_the_cell_fills_the_view_and_says_its_size(capped_scene, tmp_path):
    half = {"column": "capped", "shape": (64, 64), "q_max": 1e5, "cell": "half"}
    levels = ({"column": "capped", "shape": (64, 64), "q_max": 5e4}, half)
    scene = replace(capped_scene, numerics=replace(capped_scene.numerics, levels=levels))
    run = rs.run(scene, tmp_path / "run", max_realizations=2)
    page = Page(WatchedRun(run.folder), Document(), Now)
    page.look_for_news()
    layout = page.layout

    def view():
        return [
            (axis.start, axis.end, axis.reset_end, *axis.bounds)
            for axis in (layout.x_range, layout.y_range)
        ]

    def title():
        return layout.maps["pressure"].figure.title.text

    assert view() == [pytest.approx((0.0, 2.0, 2.0, -0.04, 2.04))] * 2  # mm
    assert "half" not in title()
    layout.controls.level.value = "1"
    layout.controls.member.value = "0"
    assert view() == [pytest.approx((0.0, 1.0, 1.0, -0.02, 1.02))] * 2
    assert title().startswith("Pressure (GPa), half the cell: 1 × 1 mm")
    pressure = run.field(1, 0, "pressure")
    limits = float(pressure.min()), float(pressure.max())
    np.testing.assert_array_equal(image(page, "pressure")["image"][0], as_bytes(pressure, limits))
    assert image(page, "pressure")["dw"] == [pytest.approx(1.0)]
    layout.x_range.end = 0.5  # a view that was chosen stays for fields of the same cell
    page.choose_member()
    assert layout.x_range.end == 0.5
    layout.controls.level.value = "0"
    assert view() == [pytest.approx((0.0, 2.0, 2.0, -0.04, 2.04))] * 2
    assert "half" not in title()
