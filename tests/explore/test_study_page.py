"""The page of a study: its controls choose what is drawn."""

from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs

pytest.importorskip("bokeh")

from bokeh.document import Document
from bokeh.models import Legend

from roughsim.explore import server
from roughsim.explore.study import StudyPage

LOADS, FRICTION = [1e8, 1.5e8, 6e8], [0.1, 0.2]


@pytest.fixture(scope="module")
def study(capped_scene, tmp_path_factory):
    levels = ({"column": "capped", "shape": [32, 32], "q_max": 4e4},)
    scene = replace(
        capped_scene,
        title="a <b>title</b>",
        numerics=replace(capped_scene.numerics, levels=levels),
        ensemble=replace(capped_scene.ensemble, until={}, max_realizations=4),
    )
    vary = {"sliding.nominal_pressure": LOADS, "sliding.friction_coefficient": FRICTION}
    return rs.study(scene, vary=vary, folder=tmp_path_factory.mktemp("studies") / "study")


@pytest.fixture
def page(study):
    return StudyPage(study.folder, Document())


def curves(page):
    """The simulated curves by their names in the legend."""
    (figure,) = page.plot.children
    (legend,) = (model for model in figure.right + figure.center if isinstance(model, Legend))
    return {item.label.value: item.renderers[0].data_source.data for item in legend.items}


def test_it_opens_with_flash_temperature_over_the_first_key_and_a_curve_for_each_value_of_the_second(page, study):
    shown = curves(page)
    assert list(shown) == ["0.1", "0.2"]
    assert np.allclose(shown["0.2"]["x"], [100.0, 150.0, 600.0])  # MPa
    runs = [run for point, run in study.results if point.values["sliding.friction_coefficient"] == 0.2]
    k = int(np.argmax(runs[0].scene.speeds))
    assert np.allclose(shown["0.2"]["y"], [run.estimate("flash_temperature").mean[k] for run in runs])
    assert page.state.text.startswith("6 of 6 points finished")


def test_drawing_asks_each_point_a_few_times_only(page, study, monkeypatch):
    # asked for each row, the time of a page grew as the square of the number of points
    asked, run = [], rs.Study.run
    monkeypatch.setattr(rs.Study, "run", lambda *arguments: asked.append(1) or run(*arguments))
    page.draw()
    assert len(asked) <= 4 * len(study.points)


def test_a_page_reads_again_only_what_has_not_finished(page, study):
    again = page.study.reread()
    assert all(again.run(point) is page.study.run(point) for point in study.points)
    first = page.study.points[0].name
    page.study.run(page.study.points[0]).max_realizations += 1  # as if more were to come
    again = page.study.reread()
    assert [again.run(p) is page.study.run(p) for p in study.points] == [p.name != first for p in study.points]


def test_controls_choose_the_observable_the_axis_and_the_curves(page):
    page.selects["observable"].value = "contact_fraction"
    assert np.all(np.diff(curves(page)["0.1"]["y"]) > 0.0)  # more load, more contact
    page.selects["observable"].value = "flash_temperature"
    page.selects["x"].value = "friction_coefficient"
    page.selects["family"].value = "speed"
    assert np.allclose(curves(page)["35 m/s"]["x"], FRICTION)
    y = curves(page)["35 m/s"]["y"]
    assert y[1] == pytest.approx(2.0 * y[0])
    assert page.selects["key nominal_pressure"].visible
    assert not page.selects["key friction_coefficient"].visible
    page.selects["key nominal_pressure"].value = str(LOADS[-1])
    assert curves(page)["35 m/s"]["y"][1] != y[1]


def test_points_are_hollow_without_a_line_where_a_part_of_the_error_is_unknown(page):
    # all have one level alone, so that nothing shows the error of the pixel
    data = curves(page)["0.2"]
    assert set(data["face"]) == {"white"}
    assert np.isnan(data["joined"]).all()
    assert set(data["at_least"]) == {"≥"}
    assert "Hollow: at q_c, or a part of the error is unknown." in page.state.text
    for row in page.rows:
        row.update(unknown="", note="")
    page.rows[0]["unknown"] = "size"
    page.draw()
    data = curves(page)["0.2"]
    assert "white" not in set(data["face"])
    assert np.array_equal(data["joined"], data["y"])
    assert set(data["at_least"]) == {""}


def test_a_title_is_text(page, study):
    (root,) = page.controls.document.roots
    head = root.children[0]
    assert head.text == "a <b>title</b>"
    assert head.render_as_text


def test_without_a_result_the_page_says_so_and_fills_when_there_is_one(page, study):
    rows, page.rows = page.rows, []
    page.draw()
    assert page.problems.text == "there is no result to draw with these values yet"
    page.rows = rows
    page.draw()
    assert page.problems.text == ""


def test_the_server_opens_the_page_of_a_study_and_refuses_other_folders(study, tmp_path):
    assert server.page_of(study.folder).func is StudyPage
    with pytest.raises(rs.RecordError, match="is no run"):
        server.page_of(tmp_path)


def test_words_and_lists_are_curves_over_the_speed(study, tmp_path):
    vary = {"sliding.heat_partition": ["mean", "all"]}
    words = rs.study(study.scene, vary=vary, folder=tmp_path / "words")
    page = StudyPage(words.folder, Document())
    assert list(curves(page)) == ["mean", "all"]
    assert np.array_equal(curves(page)["all"]["x"], words.scene.speeds)
    page.selects["observable"].value = "contact_fraction"
    assert "no result to draw" in page.problems.text


def test_speeds_varied_one_by_one_lie_along_x(study, tmp_path):
    vary = {"sliding.speed": [1.0, 10.0]}
    page = StudyPage(rs.study(study.scene, vary=vary, folder=tmp_path / "speeds").folder, Document())
    page.selects["family"].value = "none"
    (curve,) = curves(page).values()
    assert np.array_equal(curve["x"], [1.0, 10.0])
