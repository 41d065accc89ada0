"""The page of a run: a skin and the depth of the heat, chosen by sliders, without a browser."""

from dataclasses import replace

import numpy as np
import pytest
from page_cases import image, pixels, temperature
from tasks_at_once import Now

import roughsim as rs
from roughsim import pipeline
from roughsim.explore.content import WatchedRun, load_fields
from roughsim.scene.skins import SkinSection

pytest.importorskip("bokeh")
from bokeh.document import Document

from roughsim.explore.page import Page
from roughsim.explore.skin import SkinControls

STEEL = {"conductivity": 30.0, "diffusivity": 30.0 / (7900 * 500)}
OXIDE, WORKED = (3.0, 3.0 / (5200 * 650)), (15.0, 15.0 / (7900 * 500))  # κ_s and D_s


@pytest.fixture
def bare(page):
    """A page as it opens, before and after."""
    yield page
    page.layout.skin.material.value = "oxide"
    for slider in (page.layout.skin.thickness, page.layout.skin.heat_depth):
        slider.value = slider.start
    page.choose_layers()


def directly(run, speed, **layers):
    """The temperature of a body with layers by the kept pressure: μ = 0.11, nine tenths of the heat."""
    grid, pressure = run.numerics.grid(2), next(run.fields("pressure"))[1].astype(np.float64)
    return rs.sliding_temperature(
        0.9 * 0.11 * speed * pressure, grid, speed=speed, **STEEL, **layers
    )


def let_go(slider, micrometres):
    """Move a slider and release it, as the browser does."""
    slider.value = np.log10(micrometres)
    slider.trigger("value_throttled", None, slider.value)


@pytest.mark.parametrize(("material", "numbers"), [("oxide", OXIDE), ("worked", WORKED)])
def test_the_slider_of_the_thickness_shows_the_temperature_under_that_skin_of_the_same_contact(
    bare, capped_run, calls, material, numbers
):
    solved = calls(pipeline, "loaded")
    bare.layout.skin.material.value = material
    let_go(bare.layout.skin.thickness, 0.5)
    field = directly(capped_run, 35.0, skin=(5e-7, *numbers))
    np.testing.assert_allclose(
        bare.temperature.field, field, atol=1e-5 * np.abs(field).max()
    )  # single precision
    np.testing.assert_array_equal(image(bare)["image"][0], pixels(bare.temperature.field))
    assert "35 m/s, skin 0.5 µm" in bare.layout.maps["temperature"].figure.title.text
    pressure = next(capped_run.fields("pressure"))[1]
    flash = (field * pressure).sum() / pressure.sum()
    assert bare.layout.distribution.flash.location == pytest.approx(flash, rel=1e-5)
    assert not solved


def test_the_slider_of_the_depth_shows_the_temperature_by_heat_released_there(bare, capped_run):
    let_go(bare.layout.skin.heat_depth, 2.0)
    field = directly(capped_run, 35.0, heat_depth=2e-6)
    np.testing.assert_allclose(bare.temperature.field, field, atol=1e-5 * np.abs(field).max())
    bare.choose(0.1, 0.0)  # another speed keeps the depth
    field = directly(capped_run, 0.1, heat_depth=2e-6)
    np.testing.assert_allclose(bare.temperature.field, field, atol=1e-5 * np.abs(field).max())
    let_go(bare.layout.skin.thickness, 0.1)  # and so does a skin
    field = directly(capped_run, 0.1, heat_depth=2e-6, skin=(1e-7, *OXIDE))
    np.testing.assert_allclose(bare.temperature.field, field, atol=1e-5 * np.abs(field).max())


def test_at_their_first_positions_the_sliders_show_the_bits_of_the_run(bare, capped_run):
    let_go(bare.layout.skin.thickness, 1.0)
    slider = bare.layout.skin.thickness
    slider.value = slider.start
    slider.trigger("value_throttled", None, slider.value)
    np.testing.assert_array_equal(bare.temperature.field, temperature(capped_run, 35.0))
    assert "skin" not in bare.layout.maps["temperature"].figure.title.text


def test_a_slider_that_moves_shows_previews_and_late_events_change_nothing(bare):
    bare.layout.skin.thickness.value = 0.0  # 1 µm
    assert bare.temperature.preview
    bare.choose_layers()
    shown = bare.temperature
    bare.choose_layers(moving=True)  # comes late
    assert bare.temperature is shown
    assert not shown.preview


def test_the_sliders_of_a_scene_with_a_skin_begin_at_its_own(capped_run):
    run = open_with(capped_run, SkinSection(thickness=3e-7, conductivity=5.0), 4e-9)
    controls = SkinControls(run)
    assert controls.material.value == "scene"
    assert controls.material.options[0][1] == "of the scene, 5 W/(m K)"
    assert 10**controls.thickness.value == pytest.approx(0.3)  # µm
    assert 10**controls.heat_depth.value == pytest.approx(0.004)
    chosen = controls.scene()
    assert chosen.layers[0].skin == pytest.approx((3e-7, 5.0, 5.0 / (7900 * 500)))
    assert chosen.layers[0].heat_depth == pytest.approx(4e-9)
    controls.material.value = "worked"
    assert controls.scene().layers[0].skin == pytest.approx((3e-7, *WORKED))
    controls.thickness.value = controls.thickness.start
    assert controls.scene().layers[0].skin is None


def open_with(run, skin, heat_depth):
    """The same run as if its body had a skin."""
    other = rs.open_run(run.folder)
    other.scene = replace(run.scene, body=replace(run.scene.body, skin=skin, heat_depth=heat_depth))
    return other


def test_a_share_that_follows_from_both_bodies_follows_the_chosen_skin(capped_scene, tmp_path):
    counterface = replace(
        capped_scene.counterface, like=None, conductivity=30.0, density=7900.0, heat_capacity=500.0
    )
    sliding = replace(capped_scene.sliding, heat_partition="mean", speed=(35.0,))
    scene = replace(capped_scene, counterface=counterface, sliding=sliding)
    skin = SkinSection(thickness=1e-6, conductivity=3.0)
    hidden = replace(scene, body=replace(scene.body, skin=skin))
    run, other = (
        rs.run(each, tmp_path / name) for name, each in (("bare", scene), ("hidden", hidden))
    )
    for column, part in (
        ("capped", 0.1),
        ("smoothed", 0.15),
    ):  # the page changes the odds as the calibrated spectrum
        measured, own = other.heat_share(35.0, column), run.heat_share(35.0, column)
        assert own - measured > 0.05  # a worse conductor takes less
        assert run.heat_share(35.0, column, hidden) == pytest.approx(
            measured, abs=part * (own - measured)
        )
    measured = other.heat_share(35.0)
    shown = load_fields(run, 2, 0).temperature(35.0, 0.0, hidden).field
    known = next(other.fields("temperature", speed=35.0))[1]
    np.testing.assert_allclose(
        shown, known * (run.heat_share(35.0, scene=hidden) / measured), rtol=1e-5, atol=1e-3
    )


def test_a_page_of_a_run_opens_with_its_own_skin(quick, tmp_path):
    skin = SkinSection(thickness=3e-7, conductivity=3.0)
    scene = replace(quick, body=replace(quick.body, skin=skin, heat_depth=1e-7))
    run = rs.run(scene, tmp_path / "run", max_realizations=1)
    page = Page(WatchedRun(run.folder), Document(), Now)
    np.testing.assert_array_equal(
        page.temperature.field, next(run.fields("temperature", speed=35.0))[1]
    )
    assert 10**page.layout.skin.thickness.value == pytest.approx(0.3)
