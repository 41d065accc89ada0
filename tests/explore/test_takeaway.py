"""What a reader takes from the page: data of maps and of the line, looks of maps, and the state in its address."""

import numpy as np
import pytest

pytest.importorskip("bokeh")

from roughsim.explore.content import USUAL, MapLook, image_of
from roughsim.explore.takeaway import look_of, look_text, map_text
from roughsim.grid import Grid

FIELD = np.array([[1.0, 10.0], [100.0, 1000.0]])
GRID = Grid((2, 2), (2e-3, 4e-3))
WHOLE = (0.0, 2e-3), (0.0, 4e-3)


def saved(page, name):
    page.save(name)
    file, text = page.layout.takeaway.save.tags
    assert file == f"{name}.csv"
    return text


def test_a_log_scale_is_even_in_decades():
    image = image_of(FIELD, GRID, WHOLE, None, MapLook(log=True))
    np.testing.assert_array_equal(image.pixels, np.array([[0, 170], [85, 255]]))  # (y, x)
    negative = image_of(FIELD - 1.0, GRID, WHOLE, None, MapLook(log=True))
    assert negative.limits == pytest.approx((0.999, 999.0))  # three decades


def test_limits_of_a_look_come_before_those_of_the_cell():
    image = image_of(FIELD, GRID, WHOLE, (1.0, 1000.0), MapLook(low=0.0, high=100.0))
    assert image.limits == (0.0, 100.0)
    assert image.pixels.max() == 255
    assert image_of(FIELD, GRID, WHOLE, (1.0, 1000.0), MapLook(high=100.0)).limits == (1.0, 100.0)


def test_a_saved_map_has_its_values_at_their_places():
    text = map_text(image_of(FIELD, GRID, WHOLE, None), "Temperature (mK)", 1e3, "mm", 1e3)
    head, *lines = text.splitlines()
    assert head == "# Temperature (mK); x (mm) in the first column; y (mm) in the first line"
    table = np.genfromtxt(lines, delimiter=",")
    np.testing.assert_allclose(table[0, 1:], [0.0, 2.0])
    np.testing.assert_allclose(table[1:, 0], [0.0, 1.0])
    np.testing.assert_allclose(table[1:, 1:], 1e3 * FIELD)


def test_the_page_saves_the_map_and_the_line_that_it_shows(page, capped_run):
    heights = next(capped_run.fields("heights"))[1]
    table = np.genfromtxt(saved(page, "heights").splitlines()[1:], delimiter=",")[1:, 1:]
    factor = table.max() / heights.max()
    assert factor == pytest.approx(10.0 ** round(np.log10(factor)), rel=1e-6)
    head, *lines = saved(page, "line").splitlines()
    assert head.startswith("distance from the marked point along sliding (mm),h (")
    assert head.endswith(",T (K)")
    hottest = np.genfromtxt(lines, delimiter=",")
    assert hottest[hottest[:, 0] == 0.0, 3] == pytest.approx(hottest[:, 3].max())


def test_a_look_is_chosen_for_one_map(page):
    away = page.layout.takeaway
    away.low.value, away.high.value, away.colours.value, away.log.active = "1", "50", "viridis", [0]
    panel = page.layout.maps["temperature"]
    assert page.looks["temperature"] == MapLook("viridis", 1.0, 50.0, True)
    assert (panel.log_scale.low, panel.log_scale.high) == pytest.approx((1.0, 50.0))
    assert (panel.bar.visible, panel.log_bar.visible) == (False, True)
    assert panel.mapper.palette[0] == "#440154"
    assert page.looks["heights"] == USUAL
    away.low.value = "60"
    assert "from = 60 must be below to = 50" in page.layout.problems.text
    away.low.value = away.high.value = away.colours.value = ""
    away.log.active = []
    assert page.looks["temperature"] == USUAL


def test_a_link_brings_the_state_back(page):
    page.choose(10.0, 0.5)
    page.mark(0.5, 1.5)
    page.looks["pressure"] = MapLook("gray", None, 2e8)
    page.show_link()
    link, point = page.layout.takeaway.link.value, page.point
    assert "speed=10&" in link
    page.looks["pressure"] = USUAL
    page.choose(35.0, 0.0)
    page.mark(0.1, 0.1)
    page.follow(link)
    assert (page.speed, page.point) == (10.0, point)
    assert page.direction == pytest.approx(0.5, rel=1e-5)
    assert page.looks["pressure"] == MapLook("gray", None, 2e8)
    page.looks["pressure"] = USUAL


@pytest.mark.parametrize(
    "link",
    ["speed=-1", "speed=x", "angle=nan", "realization=999", "contact=77", "point=1",
     "temperature=hot,,,", "temperature=,inf,,", "temperature=1"],
)  # fmt: skip
def test_a_wrong_link_changes_nothing_but_what_is_said(page, link):
    before = page.speed, page.direction, page.point, dict(page.looks)
    page.follow(link)
    assert f"the link '{link}' cannot be followed" in page.layout.problems.text
    assert (page.speed, page.direction, page.point, dict(page.looks)) == before


@pytest.mark.parametrize("look", [MapLook("viridis", -1.0, 2.5), MapLook(log=True)])
def test_the_text_of_a_look_is_read_back(look):
    assert look_of(look_text(look)) == look
