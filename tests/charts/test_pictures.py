"""Pictures of a run: each shows what its title says, at its place, with its unit."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.figure import Figure

import roughsim as rs
from roughsim import prediction
from roughsim.charts import QUANTITIES, maps, plot_run, profile, spectra, style
from roughsim.charts.style import scaled
from roughsim.charts.subject import Subject
from roughsim.cli import main

SPEED = ("temperature", "heat_flux", "distribution", "profile")


@pytest.fixture(scope="module")
def full_run(full_scene, tmp_path_factory):
    """Full contact in an oblong cell: nothing to outline, nothing to enlarge."""
    numerics = replace(
        full_scene.numerics,
        lengths=(4e-3, 2e-3),
        levels=({"column": "elastic", "shape": [192, 96], "q_max": 1e5},),
        tolerance=1e-6,
    )
    scene = replace(full_scene, title="costs $5 & more $", numerics=numerics)
    return rs.run(scene, tmp_path_factory.mktemp("runs") / "full", max_realizations=2)


def subject(run, column="capped", speed=None, index=0):
    return Subject(run, column, run.numerics.of_column(column)[-1], index, speed)


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_every_picture_says_what_it_is_of(capped_run, tmp_path, quantity):
    path = plot_run(capped_run, quantity, tmp_path / "new" / "one.svg")
    text = path.read_text()
    assert "small capped" in text
    assert "capped contact" in text
    assert ("35 m/s" in text) == (quantity in SPEED)  # the highest speed unless told
    assert ("realization 0" in text) == (quantity not in ("spectrum", "correlation"))
    unit = {"heights": "µm", "pressure": "GPa", "heat_flux": "GW/m²", "spectrum": "m⁴", "correlation": "GPa²"}
    assert unit.get(quantity, ", K") in text


@pytest.mark.parametrize(("ending", "start"), [(".png", b"\x89PNG"), (".pdf", b"%PDF"), (".SVG", b"<?xml")])
def test_the_ending_says_the_format(capped_run, tmp_path, ending, start):
    assert plot_run(capped_run, "pressure", tmp_path / f"one{ending}").read_bytes().startswith(start)


def test_pictures_lie_beside_the_run(capped_run):
    first = plot_run(capped_run, "heights")
    assert first == capped_run.folder.resolve().parent / "capped-heights.png"
    second = plot_run(capped_run, "temperature", realization=0, speed=0.1, column="smoothed")
    assert second == first.with_name("capped-temperature-smoothed-r0-0.1mps.png")
    for path in (first, second):
        assert path.stat().st_size > 10_000
        path.unlink()


@pytest.mark.slow
@pytest.mark.parametrize("quantity", QUANTITIES)
def test_full_contact_in_an_oblong_cell_is_drawn_too(full_run, tmp_path, quantity):
    text = plot_run(full_run, quantity, tmp_path / "one.svg").read_text()
    assert "costs $5 &amp; more $" in text  # a title is no formula
    assert "elastic contact" in text


WRONG = {
    "quantity": (("gap",), {}, "quantity = 'gap' is no picture; choose one of heights, pressure"),
    "ending": (("heights", "a.gif"), {}, "must end in .png, .pdf, .svg"),
    "column": (("heights",), {"column": "elastic"}, "column = 'elastic' is not in this run"),
    "not kept": (("pressure",), {"realization": 4}, "fields of realization 4 at level 2; .*--keep-fields 5.*index=4"),
    "a mean": (("correlation",), {"realization": 0}, "mean over all"),
    "useless speed": (("heights",), {"speed": 1.0}, "speed = 1 m/s: heights does not depend on it"),
    "at rest": (("temperature",), {"speed": 0.0}, "speed = 0 m/s makes no heat"),
    "speed": (("profile",), {"speed": np.inf}, "speed = inf m/s must be finite"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_drawn_is_refused(capped_run, tmp_path, case, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words, options, message = WRONG[case]
    with pytest.raises(ValueError, match=message):
        plot_run(capped_run, *words, **options)
    assert list(tmp_path.iterdir()) == []


def test_the_command_line_draws_and_complains_in_one_line(capped_run, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["plot", str(capped_run.folder), "profile", "-o", str(tmp_path / "a.png"), "--speed", "-0.1", "-r", "0"])
    assert ended.value.code == 0
    assert "picture: " in capsys.readouterr().err
    assert (tmp_path / "a.png").exists()
    with pytest.raises(SystemExit) as ended:
        main(["plot", str(capped_run.folder), "gap"])
    assert ended.value.code == 1
    assert capsys.readouterr().err.startswith("roughsim: quantity = 'gap'")


def test_units_get_the_prefix_that_keeps_numbers_readable():
    cases = {(3.2e-6, "m"): ("µm", 3.2), (1e-3, "m"): ("mm", 1.0), (999e-9, "m"): ("nm", 999.0), (2.0, "m"): ("m", 2.0)}
    cases |= {(5e8, "Pa"): ("MPa", 500.0), (1e9, "Pa"): ("GPa", 1.0), (2e9, "W/m^2"): ("GW/m^2", 2.0)}
    cases |= {(1500.0, "K"): ("K", 1500.0), (0.0, "m"): ("m", 0.0)}
    for (value, unit), (name, number) in cases.items():
        factor, shown = scaled(value, unit)
        assert shown == name
        assert value * factor == pytest.approx(number, rel=1e-12)


def test_axis_0_is_x_and_points_stand_at_their_coordinates():
    field = np.zeros((6, 4))
    field[5, 1] = 1.0
    axes = Figure().subplots()
    image = maps.draw_field(axes, field, rs.Grid((6, 4), (12e-6, 12e-6)), maps.Window(slice(0, 6), slice(0, 4)), {})
    assert image.get_array()[1, 5] == 1.0  # rows are y
    assert image.origin == "lower"
    left, right, bottom, top = image.get_extent()  # in µm; half a point beyond the first and the last
    np.testing.assert_allclose([left, right, bottom, top], [-1.0, 11.0, -1.5, 10.5])
    assert axes.get_xlabel() == "$x$, µm"


def test_zero_pressure_is_white_and_heights_are_symmetric():
    colours = maps.colour_range("pressure", np.array([[0.0, 3.0]]))
    assert colours["cmap"](0.0) == (1.0, 1.0, 1.0, 1.0)
    assert (colours["vmin"], colours["vmax"]) == (0.0, 3.0)
    colours = maps.colour_range("heights", np.array([[-1.0, 3.0]]))
    assert (colours["vmin"], colours["vmax"]) == (-3.0, 3.0)
    lightness = colormaps["inferno"](np.linspace(0, 1, 64))[:, :3] @ [0.2126, 0.7152, 0.0722]
    assert np.all(np.diff(lightness) > 0)


def test_the_enlarged_part_holds_the_largest_value_and_stays_in_the_cell():
    rng = np.random.default_rng(2)
    for place in ((0, 0), (200, 383), *rng.integers(0, 384, (20, 2))):
        field = np.zeros((384, 400))
        field[tuple(place)] = 1.0
        part = maps.busiest_part(field)
        assert field[part].max() == 1.0
        assert field[part].shape == (192, 192)
    assert maps.busiest_part(np.zeros((383, 400))) is None


def test_a_zoom_draws_the_points_between_its_ends_alone(capped_run, drawn):
    plot_run(capped_run, "pressure", zoom=((0.5e-3, 1.0e-3), (1.0e-3, 1.25e-3)))  # of 2 mm and 128 points
    (axes, _) = drawn[-1].axes
    field = next(capped_run.fields("pressure"))[1][32:64, 64:80]
    image = axes.images[0]
    np.testing.assert_allclose(image.get_array() / field.max(), field.T.astype(float) / field.max() * scale(field))
    np.testing.assert_allclose(image.get_extent(), np.array([31.5, 63.5, 63.5, 79.5]) * 2.0 / 128 * unit_of(axes))


def scale(field):
    return scaled(float(field.max()), "Pa")[0]


def unit_of(axes):
    return {"mm": 1.0, "µm": 1000.0}[axes.get_xlabel().rpartition(" ")[2]]


@pytest.mark.parametrize(
    ("zoom", "message"),
    [
        (((0.0, 3e-3), (0.0, 1e-3)), "zoom = 0:0.003 m along x must rise and lie in the cell, 0:0.002 m"),
        (((0.0, 1e-3), (1e-3, 0.5e-3)), "along y must rise"),
        (((0.0, 1e-3), (1e-3, 1.05e-3)), "along y holds 3 points of 1.563e-05 m; at least 8"),
        (((0.0, np.nan), (0.0, 1e-3)), "zoom = nan m must be finite"),
    ],
)
def test_a_zoom_outside_the_cell_or_of_few_points_is_refused(capped_run, tmp_path, zoom, message):
    with pytest.raises(ValueError, match=message):
        plot_run(capped_run, "heights", tmp_path / "a.png", zoom=zoom)
    assert list(tmp_path.iterdir()) == []


def test_what_is_no_map_has_no_zoom_and_nothing_beside_it(capped_run, tmp_path):
    for options in ({"zoom": ((0.0, 1e-3), (0.0, 1e-3))}, {"side_by_side": True}):
        with pytest.raises(ValueError, match="are for maps, and profile is none"):
            plot_run(capped_run, "profile", tmp_path / "a.png", **options)


@pytest.mark.parametrize("third", ["temperature", "heat_flux"])
def test_fields_stand_side_by_side_over_one_part(capped_run, drawn, third):
    plot_run(capped_run, third, speed=35.0, side_by_side=True, zoom=((0.0, 1e-3), (0.0, 1e-3)))
    panels = [axes for axes in drawn[-1].axes if axes.images]
    for axes, name in zip(panels, ("heights", "pressure", third), strict=True):
        field = next(capped_run.fields(name, speed=35.0 if name == third else None))[1][:64, :64].T
        shown = np.asarray(axes.images[0].get_array())
        np.testing.assert_allclose(shown / np.abs(shown).max(), field / np.abs(field).max(), atol=1e-6)
    assert [len(axes.collections) for axes in panels] == [1, 0, 1]  # contact is outlined but where it is all there is


def test_the_command_line_takes_zoom_and_side_by_side(capped_run, tmp_path, capsys):
    words = ["plot", str(capped_run.folder), "temperature", "--zoom", "0:1e-3,5e-4:2e-3", "--side-by-side"]
    with pytest.raises(SystemExit) as ended:
        main([*words, "-o", str(tmp_path / "a.pdf")])
    assert ended.value.code == 0
    assert (tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")
    with pytest.raises(SystemExit):
        main(["plot", str(capped_run.folder), "heights", "--zoom", "1,2"])
    assert "--zoom 1,2: write X0:X1,Y0:Y1 in m" in capsys.readouterr().err


def test_a_scale_bar_is_as_long_as_it_says():
    axes = Figure().subplots()
    axes.set(xlabel="$x$, µm", xlim=(100.0, 340.0))
    maps.scale_bar(axes)
    x = axes.lines[0].get_xdata()
    assert axes.texts[0].get_text() == "50 µm"
    assert x[1] - x[0] == 50.0
    assert axes.get_xlim() == (100.0, 340.0)  # an axis does not grow for its bar
    lengths = {0.9: 0.5, 1.0: 1.0, 1.99: 1.0, 2.0: 2.0, 4.9: 2.0, 52.0: 50.0, 1e-3: 1e-3}
    for given, found in lengths.items():
        assert maps.round_length(given) == pytest.approx(found, rel=1e-12)


def test_the_distribution_chart_has_the_shares_of_the_contact(capped_run, monkeypatch):
    figures = []
    monkeypatch.setattr(style, "save", lambda figure, path: figures.append(figure))
    plot_run(capped_run, "distribution", speed=35.0)
    temperature = next(capped_run.fields("temperature", speed=35.0))[1].astype(float)
    pressure = next(capped_run.fields("pressure"))[1].astype(float)
    values, weights = temperature[pressure > 0], pressure[pressure > 0]
    density, hotter = figures[0].axes
    for patch, mean in zip(density.patches, (values.mean(), np.average(values, weights=weights)), strict=True):
        heights, edges, _ = patch.get_data()
        width = np.diff(edges)
        assert (heights * width).sum() == pytest.approx(100.0)
        assert (heights * width) @ (edges[1:] + edges[:-1]) / 200 == pytest.approx(mean, abs=width[0] / 2)
    area, heat = hotter.lines[:2]
    middle = np.median(values)
    assert np.interp(middle, *area.get_data()) == pytest.approx(50.0, abs=0.5)
    exact = 100 * weights[values > middle].sum() / weights.sum()
    assert np.interp(middle, *heat.get_data()) == pytest.approx(exact, abs=0.5)
    text = figures[0].get_suptitle()
    assert f"{np.average(values, weights=weights):.4g} K (dashed)" in text


def test_the_line_of_the_theory_has_the_heat_share_of_its_points(capped_run, monkeypatch):
    figures = []
    monkeypatch.setattr(style, "save", lambda figure, path: figures.append(figure))
    rs.compare(capped_run).chart("a.png")
    line = figures[0].axes[2].lines[0]
    (speed, value), exact = line.get_data(), prediction.predictions(capped_run.scene)["flash_temperature"][2]
    at = np.exp(np.interp(np.log(35.0), np.log(speed), np.log(value)))
    assert at == pytest.approx(0.9 * exact, rel=2e-3)  # interpolated


def test_the_contact_is_enlarged_where_most_of_it_is():
    pressure = np.zeros((512, 512))
    pressure[300:340, 100:140] = 1.0
    pressure[50, 400] = 100.0  # one hard point is not much contact
    part = maps.busiest_part(maps.averaged(pressure))
    assert pressure[part].sum() == 1600.0


def test_the_profile_runs_along_x_through_the_hottest_point(capped_run):
    one = subject(capped_run, speed=35.0)
    hottest, across, lines = profile.lines_through_hottest_point(one)
    temperature = next(capped_run.fields("temperature", speed=35.0))[1]
    assert temperature[hottest, across] == temperature.max() == lines["temperature"].max()
    np.testing.assert_array_equal(lines["pressure"], next(capped_run.fields("pressure"))[1][:, across])


def test_a_wave_has_its_variance_in_the_measured_spectrum():
    # ⟨h²⟩ = 2π ∫ q C dq: a cosine of amplitude a has a²/2, wherever it lies
    grid = rs.Grid((128, 96), (3e-3, 2e-3))
    x, y = np.meshgrid(np.arange(128) * 3e-3 / 128, np.arange(96) * 2e-3 / 96, indexing="ij")
    q1, q2 = 2 * np.pi * 17 / 3e-3, 2 * np.pi * 9 / 2e-3
    heights = 2e-6 * np.cos(q1 * x + q2 * y + 0.3)
    q = np.geomspace(0.5 * np.hypot(q1, q2), 2 * np.hypot(q1, q2), 4000)
    density = 2 * np.pi * q**2 * spectra.radial_psd(heights, grid, q, (0.0, np.inf))
    assert np.trapezoid(density, np.log(q)) == pytest.approx(2e-12, rel=0.05)  # few modes near it: their density varies
    assert q[density.argmax()] == pytest.approx(np.hypot(q1, q2), rel=0.05)


def test_a_drawn_surface_has_the_spectrum_that_it_was_drawn_from():
    spectrum = rs.SelfAffineSpectrum.from_rms_height(1e-6, hurst=0.8, q_min=2e4, q_max=4e5)
    grid = rs.Grid((512, 512), (2e-3, 2e-3))
    heights = rs.synthesize(spectrum, grid, np.random.default_rng(1), amplitudes="fixed")
    q = np.geomspace(2.5e4, 3.5e5, 30)
    measured = spectra.radial_psd(heights, grid, q, (2.3e4, 3.97e5))
    # the mean over the Fourier cell of a steep C exceeds C in its middle, by ΔC·cell²/24 ~ (3.6·2π/qL)²/24 and less
    np.testing.assert_allclose(measured / spectrum(q), 1.0, atol=0.02)


def test_the_stress_spectrum_of_full_contact_is_exact(full_scene):
    q = np.geomspace(7e3, 9.9e4, 20)
    exact = (full_scene.effective_modulus * q / 2) ** 2 * full_scene.spectrum(q)  # every wave pressed flat: W = 1
    np.testing.assert_allclose(prediction.stress_spectrum(full_scene, q), exact, rtol=1e-9)


def test_the_stress_spectrum_sums_to_the_variance_of_the_pressure(capped_scene):
    nodes, weights = np.polynomial.legendre.leggauss(400)
    total = 0.0
    for low, high in ((6350.0, 2e4), (2e4, 4e4), (4e4, 2e5)):  # C has a kink at 2e4
        q = np.exp((np.log(high / low) * nodes + np.log(high * low)) / 2)
        density = 2 * np.pi * q**2 * prediction.stress_spectrum(capped_scene, q)
        total += np.log(high / low) / 2 * float(weights @ density)
    assert total == pytest.approx(prediction.predictions(capped_scene)["pressure_variance"][0], rel=1e-6)


def test_the_measured_stress_spectrum_sums_to_the_measured_variance(capped_run):
    one, axes = subject(capped_run, index=None), Figure().subplots()
    spectra.draw_stress_spectrum(axes, one)
    line = next(
        line for line in axes.lines if line.get_color() == style.COLOURS["capped"] and len(line.get_xdata()) > 9
    )
    q, density = line.get_data()
    sample = capped_run.samples("capped")[-1]
    inside = sample.wavenumber < q[-1]
    assert np.trapezoid(density, np.log(q)) == pytest.approx(1e-18 * sample.spectrum[:, inside].sum(1).mean(), rel=0.03)


@pytest.fixture
def drawn(monkeypatch):
    """What a chart would have written: its figure."""
    figures = []
    monkeypatch.setattr(style, "save", lambda figure, path: figures.append(figure))
    return figures


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
        assert bar.get_ylabel().endswith(f", {unit}")


def test_contact_is_outlined_where_it_is(full_run):
    grid, pressure = rs.Grid((40, 30), (4e-3, 6e-3)), np.zeros((40, 30))
    pressure[10:20, 5:8] = 1.0
    axes = Figure().subplots()
    maps.outline_contact(axes, pressure, grid, maps.Window(slice(8, 30), slice(2, 20)))
    (lines,) = axes.collections
    corners = np.vstack([path.vertices for path in lines.get_paths()])
    # between the last point without contact and the first with it: x = 9.5 … 19.5 of 0.1 mm, y = 4.5 … 7.5 of 0.2 mm
    np.testing.assert_allclose(corners.min(0), [0.95, 0.9])
    np.testing.assert_allclose(corners.max(0), [1.95, 1.5])


def test_the_frame_shows_what_is_enlarged(capped_run, monkeypatch, drawn):
    monkeypatch.setattr(maps, "ENLARGED", 32)
    plot_run(capped_run, "temperature")
    whole, part = drawn[0].axes[:2]
    (frame,) = whole.patches
    left, right, bottom, top = part.images[0].get_extent()
    unit = 1e-3 if part.get_xlabel() != whole.get_xlabel() else 1.0  # µm beside mm
    half = 0.51 * 2.0 / 128
    np.testing.assert_allclose(frame.get_x(), left * unit, atol=half)
    np.testing.assert_allclose(frame.get_y(), bottom * unit, atol=half)
    np.testing.assert_allclose([frame.get_width(), frame.get_height()], [(right - left) * unit, (top - bottom) * unit])
    assert part.images[0].get_array().max() == whole.images[0].get_array().max()  # the hottest point


@pytest.mark.parametrize("speed", [35.0, -35.0])
def test_the_arrow_points_where_the_source_slides(capped_run, drawn, speed):
    plot_run(capped_run, "temperature", speed=speed)
    arrow = next(text for text in drawn[0].axes[0].texts if hasattr(text, "xyann"))
    assert np.sign(arrow.xy[0] - arrow.xyann[0]) == np.sign(speed)


def test_profiles_show_their_values(capped_run, drawn):
    plot_run(capped_run, "profile", speed=35.0)
    _, _, lines = profile.lines_through_hottest_point(subject(capped_run, speed=35.0))
    factors = {"heights": 1e6, "pressure": 1e-9, "temperature": 1.0}
    for axes, (name, factor) in zip(drawn[0].axes, factors.items(), strict=True):
        x, values = axes.lines[0].get_data()
        np.testing.assert_allclose(values, lines[name] * factor, rtol=1e-12)
        np.testing.assert_allclose(x, np.arange(128) * 2.0 / 128)  # mm
    assert [axes.get_ylabel() for axes in drawn[0].axes] == ["$h$, µm", r"$\sigma$, GPa", "$T$, K"]


def test_full_contact_has_the_stress_spectrum_of_the_theory(full_run, drawn):
    # all waves are pressed flat: |σ_q|² = (E*q/2)² C exactly, drawn twice on different ways
    plot_run(full_run, "spectrum")
    theory, measured = drawn[0].axes[1].lines[:2]
    q = np.geomspace(1.2e4, 8e4, 30)
    there = np.interp(q, *measured.get_data()) / np.interp(q, *theory.get_data())
    np.testing.assert_allclose(there, 1.0, atol=0.03)
    q, heights = drawn[0].axes[0].lines[1].get_data()
    far = q > 1.2e4  # nearer to q_min a mode's Fourier cell is wide: its mean exceeds the steep C in the middle
    np.testing.assert_allclose(heights[far], full_run.scene.spectrum(q[far]), rtol=0.03)


WIDE = 2.5705818 * np.sqrt(1 + 2 / 5)  # Student at 5 degrees of freedom, widened for runs that stop themselves


def half_band(axes):
    """Half the height of the band of a chart, and where."""
    (band,) = axes.collections
    corners = band.get_paths()[0].vertices
    x = np.unique(corners[:, 0])
    return x, np.array([np.ptp(corners[corners[:, 0] == value, 1]) for value in x]) / 2


def test_bands_are_intervals_of_95_percent(capped_run, drawn):
    plot_run(capped_run, "correlation")
    for axes in drawn[0].axes[:2]:
        r, half = half_band(axes)
        mean, error = capped_run.correlation(r * 1e-6)
        np.testing.assert_allclose(half, WIDE * 1e-18 * error, rtol=1e-6, atol=1e-9)
        theory, measured = axes.lines[:2]
        np.testing.assert_allclose(measured.get_ydata(), mean * 1e-18, rtol=1e-6, atol=1e-9)
        exact = 1e-18 * prediction.predictions(capped_run.scene)["pressure_variance"][0]
        assert theory.get_ydata()[0] == pytest.approx(exact, rel=1e-4)
    plot_run(capped_run, "spectrum")
    _, half = half_band(drawn[1].axes[1])
    one = [curve(capped_run, index) for index in range(6)]
    np.testing.assert_allclose(half, WIDE * np.std(one, axis=0, ddof=1) / np.sqrt(6), rtol=1e-6)


def curve(run, index):
    """The stress spectrum of one member as it is drawn."""
    axes = Figure().subplots()
    spectra.draw_stress_spectrum(axes, subject(run, index=index))
    return axes.lines[1].get_ydata()
