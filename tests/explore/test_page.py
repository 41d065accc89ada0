"""The page of a run: what its controls show, without a browser."""

import numpy as np
import pytest
from page_cases import image, pixels, temperature
from tasks_at_once import Now

from roughsim.explore.content import load_fields

pytest.importorskip("bokeh")
from bokeh.document import Document

from roughsim.explore.page import Page


def test_the_page_opens_with_the_fields_and_their_real_limits(page, capped_run):
    fields = {
        "pressure": next(capped_run.fields("pressure"))[1] / 1e9,
        "temperature": temperature(capped_run, 35.0),
    }
    heights = next(capped_run.fields("heights"))[1] * 1e6
    for name, field in fields.items():
        scale = page.layout.maps[name].scale
        assert (scale.low, scale.high) == pytest.approx((field.min(), field.max()), rel=1e-6)
        np.testing.assert_array_equal(image(page, name)["image"][0], pixels(field))
    # what is at the hardness is grey, and the title says how much of the contact that is
    contact = next(capped_run.fields("pressure"))[1]
    hard = 100 * (contact > 0.99999 * 1e9).sum() / (contact > 0).sum()
    assert f"grey: {hard:.3g} % at σ_P" in page.layout.maps["pressure"].figure.title.text
    assert {name: panel.mapper.high for name, panel in page.layout.maps.items()} == dict(
        heights=255, pressure=254, temperature=255
    )
    scale = page.layout.maps["heights"].scale
    assert (-scale.low, scale.high) == pytest.approx((np.abs(heights).max(),) * 2, rel=1e-6)
    assert page.layout.state.text.startswith("6 realizations")
    assert page.layout.state.text.endswith("finished: all realizations are there")
    assert page.layout.maps["temperature"].figure.title.text == "Temperature (K), 35 m/s"
    assert image(page)["dw"] == pytest.approx([2.0])  # mm
    assert page.layout.problems.text == ""


def test_controls_of_what_a_run_lacks_are_hidden(page):
    # reactions, a camera, directions, and snapshots of a slide
    assert not page.reactions.figures
    assert page.reactions.root not in page.layout.root.children
    assert not page.layout.skin.camera.visible
    assert "camera" not in page.layout.maps["temperature"].figure.title.text
    assert not page.controls.direction.visible
    assert page.direction == 0.0
    assert page.snapshots is None
    assert page.layout.root.select_one({"name": "snapshots"}) is None


def test_axes_are_shown_with_their_data_and_hidden_without(page):
    layout = page.layout
    figures = [
        *(panel.figure for panel in layout.maps.values()),
        *layout.line.figures,
        layout.distribution.figure,
    ]
    assert all(figure.visible for figure in figures)
    layout.clear()
    assert not any(figure.visible for figure in figures)
    page.choose_member()
    assert all(figure.visible for figure in figures)


def test_a_page_is_sound_for_bokeh_and_says_that_its_mean_is_of_one_field(page, caplog):
    from bokeh.core.validation import check_integrity, process_validation_issues

    issues = check_integrity(page.layout.root.references())
    process_validation_issues(issues)  # what bokeh prints in the terminal when a page is opened
    assert (issues.error, issues.warning, caplog.text) == ([], [], "")
    mean = temperature_of_contact(page)
    assert page.layout.distribution.figure.title.text.startswith(
        f"This field, at its q_c: ⟨Tσ⟩/⟨σ⟩ = {mean:.4g} K"
    )


def temperature_of_contact(page):
    """⟨Tσ⟩/⟨σ⟩ of the shown field."""
    pressure, field = page.member.pressure, page.temperature.field
    return (pressure * field.astype(float)).sum() / pressure.sum(dtype=float)


def test_the_slider_shows_the_temperature_at_its_speed(page, capped_run):
    page.layout.controls.slider.value = -0.5
    field = temperature(capped_run, 10.0**-0.5)
    np.testing.assert_array_equal(image(page)["image"][0], pixels(field))
    page.choose(10.0**-0.5, 0.0)
    assert page.layout.controls.speed.value == "0.3162"
    bins = page.layout.distribution.bins.data
    contact = field[next(capped_run.fields("pressure"))[1] > 0]
    assert (bins["left"][0], bins["right"][-1]) == pytest.approx(
        (contact.min(), contact.max()), rel=1e-6
    )
    assert (bins["area"] * (bins["right"] - bins["left"])).sum() == pytest.approx(100.0)  # per cent
    assert all(
        panel.chosen_speed.location == pytest.approx(10.0**-0.5)
        for panel in page.layout.curves.values()
    )


def test_one_move_replaces_one_source_once(page):
    replaced = []
    page.layout.maps["temperature"].image.on_change(
        "data", lambda attr, old, new: replaced.append(new)
    )
    page.layout.controls.slider.value = 0.25
    assert len(replaced) == 1


def test_a_large_field_is_previewed_and_then_shown_whole(watched):
    page = Page(watched, Document(), Now)
    page.show_member(load_fields(watched.run, 2, 0, preview=64))
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
        page.layout.controls.angle.trigger(
            "value_throttled", None, angle
        )  # the browser sets it, on release
        assert not page.temperature.preview
    field = temperature(capped_run, 35.0, np.radians(angle))
    np.testing.assert_array_equal(page.temperature.field, field)
    np.testing.assert_array_equal(image(page)["image"][0], pixels(field))
    assert page.layout.controls.angle.value == angle


@pytest.mark.parametrize(
    ("direction", "degrees"), [(0.0, 0), (np.pi / 2, 90), (1.5 * np.pi, -90), (-7.0, -41)]
)
def test_the_slider_of_the_direction_shows_the_turn_that_is_least(page, direction, degrees):
    page.choose(35.0, direction)
    assert page.layout.controls.angle.value == degrees


def test_a_speed_can_be_written(page, capped_run):
    page.layout.controls.speed.value = "3.7"
    assert page.temperature.speed == 3.7
    assert 10**page.layout.controls.slider.value == pytest.approx(3.7, rel=0.03)
    field = temperature(capped_run, 3.7)
    np.testing.assert_array_equal(image(page)["image"][0], pixels(field))


@pytest.mark.parametrize(
    ("text", "message"), [("fast", "is no number"), ("-1", "positive"), ("nan", "finite")]
)
def test_a_wrong_speed_is_refused_in_words(page, text, message):
    page.layout.controls.speed.value = text
    assert message in page.layout.problems.text
    assert page.temperature.speed == 35.0
    page.layout.controls.speed.value = "20000"  # beyond the slider, and none the less there
    assert page.temperature.speed == 20000.0
    assert page.layout.problems.text == ""
