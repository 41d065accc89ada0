"""The page of a study: its controls choose what is drawn."""

import re
from base64 import b64decode
from dataclasses import replace

import pytest
from study_cases import description_of

import roughsim as rs

pytest.importorskip("bokeh")

from bokeh.document import Document

from roughsim.explore import server
from roughsim.explore.study import StudyPage
from roughsim.studies.folder import write

LOADS, FRICTION = [1e8, 1.5e8, 6e8], [0.1, 0.2]
VARY = {"sliding.nominal_pressure": LOADS, "sliding.friction_coefficient": FRICTION}


@pytest.fixture(scope="module")
def study(capped_scene, tmp_path_factory):
    levels = ({"column": "capped", "shape": [32, 32], "q_max": 4e4},)
    scene = replace(
        capped_scene,
        title="a <b>title</b>",
        numerics=replace(capped_scene.numerics, levels=levels),
        ensemble=replace(capped_scene.ensemble, until={}, max_realizations=2),
    )
    return rs.study(scene, vary=VARY, folder=tmp_path_factory.mktemp("studies") / "study")


@pytest.fixture(scope="module")
def document():
    return Document()


@pytest.fixture(scope="module")
def page(study, document):
    return StudyPage(study.folder, document)


def picture(page):
    """The text of the figure, an SVG inside the page."""
    content = re.search('src="data:image/svg\\+xml;base64,([^"]+)"', page.figure.text)[1]
    return b64decode(content).decode()


def test_it_opens_with_flash_temperature_over_the_first_key_and_a_curve_for_each_value_of_the_second(
    page,
):
    choice = page.choice()
    assert (choice.observable, choice.x, choice.family) == (
        "flash_temperature",
        "nominal_pressure",
        "friction_coefficient",
    )
    text = picture(page)
    for words in (
        "nominal pressure (MPa)",
        "flash temperature (K)",
        "friction coefficient",
        ">0.1<",
        ">0.2<",
    ):
        assert words in text
    assert page.state.text == "6 of 6 points finished"


def test_a_page_reads_again_only_what_has_not_finished(page, study):
    again = page.study.reread()
    assert all(again.run(point) is page.study.run(point) for point in study.points)
    first = page.study.points[0].name
    unfinished = page.study.run(page.study.points[0])
    unfinished.max_realizations += 1  # as if more were to come
    unfinished.refresh()
    again = page.study.reread()
    assert [again.run(p) is page.study.run(p) for p in study.points] == [
        p.name != first for p in study.points
    ]


def test_controls_choose_the_observable_the_axis_and_the_curves(study):
    page = StudyPage(study.folder, Document())
    page.selects["observable"].value = "contact_fraction"
    assert "contact fraction" in picture(page)
    page.selects["observable"].value = "flash_temperature"
    page.selects["x"].value = "friction_coefficient"
    page.selects["family"].value = "speed"
    assert page.selects["key nominal_pressure"].visible
    assert not page.selects["key friction_coefficient"].visible
    page.selects["key nominal_pressure"].value = str(LOADS[-1])
    assert page.choice().fixed["nominal_pressure"] == LOADS[-1]
    text = picture(page)
    assert "nominal pressure 600 MPa" in text
    assert "speed (m/s)" in text


def test_a_title_is_text(document, page):
    head = document.roots[0].children[0]
    assert head.text == "a <b>title</b>"
    assert head.render_as_text


def test_without_a_result_the_page_says_so_and_fills_when_there_is_one(study, tmp_path):
    write(tmp_path, description_of(study.scene, VARY))
    page = StudyPage(tmp_path, Document())
    assert "nothing to draw: no point has flash_temperature" in page.problems.text
    assert page.figure.text == ""
    page.study = study
    page.draw()
    assert page.problems.text == ""
    assert "flash temperature (K)" in picture(page)


def test_the_server_opens_the_page_of_a_study(study):
    assert server.page_of(study.folder).func is StudyPage


def test_words_are_curves_over_the_speed(study, tmp_path):
    vary = {"sliding.heat_partition": ["mean", "all"]}
    words = rs.study(study.scene, vary=vary, folder=tmp_path / "words")
    page = StudyPage(words.folder, Document())
    assert (page.choice().x, page.choice().family) == ("speed", "sliding_heat_partition")
    assert all(word in picture(page) for word in (">mean<", ">all<"))
    page.selects["observable"].value = "contact_fraction"
    assert "nothing to draw" in page.problems.text


def test_speeds_varied_one_by_one_lie_along_x(study, tmp_path):
    vary = {"sliding.speed": [1.0, 10.0]}
    page = StudyPage(
        rs.study(study.scene, vary=vary, folder=tmp_path / "speeds").folder, Document()
    )
    assert (page.choice().x, page.choice().family) == ("sliding_speed", "none")
    assert "speed (m/s)" in picture(page)
