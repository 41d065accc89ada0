"""Maps: values at their place, with their unit, enlarged where the contact is."""

import numpy as np
import pytest
from chart_cases import SPEED
from matplotlib import colormaps
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from scipy.ndimage import gaussian_filter

import roughsim as rs
from roughsim.charts import maps
from roughsim.charts.plot import plot_run
from roughsim.charts.style import Look, scaled


def test_axis_0_is_x_and_points_stand_at_their_coordinates():
    field = np.zeros((6, 4))
    field[5, 1] = 1.0
    axes = Figure().subplots()
    image = maps.draw_field(
        axes, field, rs.Grid((6, 4), (12e-6, 12e-6)), (slice(0, 6), slice(0, 4)), {}
    )
    assert image.get_array()[1, 5] == 1.0  # rows are y
    assert image.origin == "lower"
    left, right, bottom, top = (
        image.get_extent()
    )  # in µm; half a point beyond the first and the last
    np.testing.assert_allclose([left, right, bottom, top], [-1.0, 11.0, -1.5, 10.5])
    assert axes.get_xlabel() == "$x$ (µm)"


def test_the_busiest_part_is_found_in_a_pressure_blurred_by_an_eighth_of_its_side():
    pressure = np.random.default_rng(3).random((200, 300))
    blurred = gaussian_filter(pressure, maps.ENLARGED / 8, mode="wrap", truncate=8.0)
    np.testing.assert_allclose(maps.averaged(pressure), blurred, rtol=1e-6)


def test_zero_pressure_is_white_and_heights_are_symmetric():
    colours = maps.colour_range("pressure", np.array([[0.0, 3.0]]))
    assert colours["cmap"](0.0) == (1.0, 1.0, 1.0, 1.0)
    assert (colours["vmin"], colours["vmax"]) == (0.0, 3.0)
    colours = maps.colour_range("heights", np.array([[-1.0, 3.0]]))
    assert (colours["vmin"], colours["vmax"]) == (-3.0, 3.0)
    lightness = colormaps["inferno"](np.linspace(0, 1, 64))[:, :3] @ [0.2126, 0.7152, 0.0722]
    assert np.all(np.diff(lightness) > 0)


def test_maps_show_the_values_in_the_unit_of_the_bar(capped_run, drawn):
    values = {
        "heights": ("µm", 1e6),
        "pressure": ("GPa", 1e-9),
        "temperature": ("K", 1.0),
        "heat_flux": ("GW/m²", 1e-9),
    }
    for name, (unit, factor) in values.items():
        speed = 35.0 if name in SPEED else None
        plot_run(capped_run, name, speed=speed)
        image, bar = drawn[-1].axes[0].images[0], drawn[-1].axes[-1]
        field = next(capped_run.fields(name, speed=speed))[1]
        np.testing.assert_allclose(image.get_array(), field.T.astype(float) * factor, rtol=1e-6)
        assert bar.get_ylabel().endswith(f" ({unit})")


def test_the_enlarged_part_holds_the_largest_value_and_stays_in_the_cell():
    rng = np.random.default_rng(2)
    for place in ((0, 0), (200, 383), *rng.integers(0, 384, (20, 2))):
        field = np.zeros((384, 400))
        field[tuple(place)] = 1.0
        part = maps.busiest_part(field)
        assert field[part].max() == 1.0
        assert field[part].shape == (192, 192)
    assert maps.busiest_part(np.zeros((383, 400))) is None


def test_the_contact_is_enlarged_where_most_of_it_is():
    pressure = np.zeros((512, 512))
    pressure[300:340, 100:140] = 1.0
    pressure[50, 400] = 100.0  # one hard point is not much contact
    part = maps.busiest_part(maps.averaged(pressure))
    assert pressure[part].sum() == 1600.0


@pytest.fixture
def small_enlargement(monkeypatch):
    """Enlarged parts of 32 points, for a run of 128."""
    monkeypatch.setattr(maps, "ENLARGED", 32)


def test_the_frame_shows_what_is_enlarged(capped_run, small_enlargement, drawn):
    plot_run(capped_run, "temperature")
    whole, part = drawn[0].axes[:2]
    (frame,) = whole.patches
    left, right, bottom, top = part.images[0].get_extent()
    unit = 1e-3 if part.get_xlabel() != whole.get_xlabel() else 1.0  # µm beside mm
    half = 0.51 * 2.0 / 128
    np.testing.assert_allclose(frame.get_x(), left * unit, atol=half)
    np.testing.assert_allclose(frame.get_y(), bottom * unit, atol=half)
    np.testing.assert_allclose(
        [frame.get_width(), frame.get_height()], [(right - left) * unit, (top - bottom) * unit]
    )
    assert (
        part.images[0].get_array().max() == whole.images[0].get_array().max()
    )  # the hottest point


def test_a_zoom_draws_the_points_between_its_ends_alone(capped_run, drawn):
    plot_run(
        capped_run, "pressure", zoom=((0.5e-3, 1.0e-3), (1.0e-3, 1.25e-3))
    )  # of 2 mm and 128 points
    (axes, _) = drawn[-1].axes
    field = next(capped_run.fields("pressure"))[1][32:64, 64:80]
    image = axes.images[0]
    factor = scaled(float(field.max()), "Pa")[0]
    np.testing.assert_allclose(image.get_array(), field.T.astype(float) * factor, rtol=1e-6)
    unit = {"(mm)": 1.0, "(µm)": 1000.0}[axes.get_xlabel().rpartition(" ")[2]]
    np.testing.assert_allclose(
        image.get_extent(), np.array([31.5, 63.5, 63.5, 79.5]) * 2.0 / 128 * unit
    )


@pytest.mark.parametrize(
    ("zoom", "message"),
    [
        (
            ((0.0, 3e-3), (0.0, 1e-3)),
            "zoom = 0:0.003 m along x must rise and lie in the cell, 0:0.002 m",
        ),
        (((0.0, 1e-3), (1e-3, 0.5e-3)), "along y must rise"),
        (((0.0, 1e-3), (1e-3, 1.05e-3)), "along y holds 3 points of 1.563e-05 m; at least 8"),
        (((0.0, np.nan), (0.0, 1e-3)), "zoom = nan m must be finite"),
    ],
)
def test_a_zoom_outside_the_cell_or_of_few_points_is_refused(capped_run, tmp_path, zoom, message):
    with pytest.raises(ValueError, match=message):
        plot_run(capped_run, "heights", tmp_path / "a.png", zoom=zoom)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("third", ["temperature", "heat_flux"])
def test_fields_stand_side_by_side_over_one_part(capped_run, drawn, third):
    plot_run(capped_run, third, speed=35.0, side_by_side=True, zoom=((0.0, 1e-3), (0.0, 1e-3)))
    panels = [axes for axes in drawn[-1].axes if axes.images]
    for axes, name in zip(panels, ("heights", "pressure", third), strict=True):
        field = next(capped_run.fields(name, speed=35.0 if name == third else None))[1][:64, :64].T
        shown = np.asarray(axes.images[0].get_array())
        np.testing.assert_allclose(
            shown / np.abs(shown).max(), field / np.abs(field).max(), atol=1e-6
        )
    assert [len(axes.collections) for axes in panels] == [
        1,
        0,
        1,
    ]  # contact is outlined but where it is all there is


def test_contact_is_outlined_where_it_is():
    grid, pressure = rs.Grid((40, 30), (4e-3, 6e-3)), np.zeros((40, 30))
    pressure[10:20, 5:8] = 1.0
    axes = Figure().subplots()
    maps.draw_field(axes, pressure, grid, (slice(8, 30), slice(2, 20)), {}, pressure)
    (lines,) = axes.collections
    corners = np.vstack([path.vertices for path in lines.get_paths()])
    # between the last point without contact and the first with it: x = 9.5 … 19.5 of 0.1 mm, y = 4.5 … 7.5 of 0.2 mm
    np.testing.assert_allclose(corners.min(0), [0.95, 0.9])
    np.testing.assert_allclose(corners.max(0), [1.95, 1.5])


def drawn_length(bar):
    """The length of the bar that is drawn, in units of the axis."""
    return bar.size_bar.get_children()[0].get_width()


def test_a_scale_bar_is_as_long_as_it_says():
    axes = Figure().subplots()
    axes.set(xlabel="$x$ (µm)", xlim=(100.0, 340.0))
    maps.scale_bar(axes, "µm")
    (bar,) = axes.artists
    assert bar.txt_label.get_text() == "50 µm"
    assert drawn_length(bar) == 50.0
    assert bar.patch.get_alpha() > 0.8  # a plate under it: it can be read over any colour
    assert axes.get_xlim() == (100.0, 340.0)  # an axis does not grow for its bar
    for longest, length in {
        0.9: 0.5,
        1.0: 1.0,
        1.99: 1.0,
        2.0: 2.0,
        4.9: 2.0,
        52.0: 50.0,
        1e-3: 1e-3,
    }.items():
        axes.set_xlim(0.0, longest / 0.22)
        maps.scale_bar(axes, "µm")
        assert drawn_length(axes.artists[-1]) == pytest.approx(length, rel=1e-12)


@pytest.mark.parametrize("speed", [35.0, -35.0])
def test_the_arrow_points_where_the_source_slides(capped_run, drawn, speed):
    plot_run(capped_run, "temperature", speed=speed)
    arrow = next(text for text in drawn[0].axes[0].texts if hasattr(text, "xyann"))
    assert np.sign(arrow.xy[0] - arrow.xyann[0]) == np.sign(speed)


def test_a_capped_map_shows_what_varies_and_what_has_yielded_is_grey(capped_run, drawn):
    plot_run(capped_run, "pressure")
    figure, pressure = drawn[-1], next(capped_run.fields("pressure"))[1]
    image, hardness = figure.axes[0].images[0], capped_run.scene.penetration_hardness
    colours, unit = image.to_rgba(np.asarray(image.get_array())), scaled(hardness, "Pa")[0]
    grey = np.all(np.isclose(colours, to_rgba(maps.HARD)), axis=-1).T
    np.testing.assert_array_equal(grey, np.isclose(pressure, hardness, rtol=1e-5))
    share = 100 * grey.sum() / np.count_nonzero(pressure)
    assert f"grey: {share:.3g} % of it, at the hardness" in figure.get_suptitle()
    assert image.norm.vmax == pytest.approx(hardness * unit, rel=1e-4)
    elastic = (pressure > 0.0) & ~grey
    assert elastic.any()
    assert len(np.unique(colours.transpose(1, 0, 2)[elastic], axis=0)) > 20
    np.testing.assert_array_equal(
        np.all(colours == 1.0, axis=-1).T, pressure == 0.0
    )  # no contact is white


def test_elastic_contact_above_the_hardness_has_no_grey(capped_run, drawn):
    plot_run(capped_run, "pressure", column="smoothed")
    image = drawn[-1].axes[0].images[0]
    assert image.norm.vmax == np.asarray(image.get_array()).max()
    assert "grey" not in drawn[-1].get_suptitle()


def test_a_narrow_figure_has_one_panel_without_outlines(capped_run, small_enlargement, drawn):
    plot_run(capped_run, "temperature", look=Look(size=(3.4, 2.8)))
    assert [len(axes.images) for axes in drawn[-1].axes] == [1, 0]  # and the bar
    assert not drawn[-1].axes[0].patches
