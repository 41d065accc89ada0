"""Curves of a run: spectra, correlation, profile, distribution, and the theory beside them."""

import numpy as np
import pytest
from chart_cases import subject
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import roughsim as rs
from roughsim import prediction
from roughsim.charts import curves, spectra, temperature
from roughsim.charts.plot import plot_run
from roughsim.charts.style import CALIBRATED, COLOURS
from roughsim.heat.statistics import contact_temperature


def test_the_distribution_chart_has_the_shares_of_the_contact(capped_run, drawn):
    plot_run(capped_run, "distribution", speed=35.0)
    field = next(capped_run.fields("temperature", speed=35.0))[1].astype(float)
    pressure = next(capped_run.fields("pressure"))[1].astype(float)
    values, weights = field[pressure > 0], pressure[pressure > 0]
    density, hotter, both, _ = drawn[0].axes
    for patch, mean in zip(
        density.patches, (values.mean(), np.average(values, weights=weights)), strict=True
    ):
        heights, edges, _ = patch.get_data()
        width = np.diff(edges)
        assert (heights * width).sum() == pytest.approx(100.0)
        assert (heights * width) @ (edges[1:] + edges[:-1]) / 200 == pytest.approx(
            mean, abs=width[0] / 2
        )
    area, heat = hotter.lines[:2]
    middle = np.median(values)
    assert np.interp(middle, *area.get_data()) == pytest.approx(50.0, abs=0.5)
    exact = 100 * weights[values > middle].sum() / weights.sum()
    assert np.interp(middle, *heat.get_data()) == pytest.approx(exact, abs=0.5)
    text = drawn[0].get_suptitle()
    assert f"{np.average(values, weights=weights):.4g} K (dashed)" in text
    (mesh,) = both.collections
    percent, corners = (
        mesh.get_array().filled(0.0),
        mesh.get_coordinates(),
    )  # rows are bins of the temperature
    assert percent.sum() == pytest.approx(100.0)
    x, y = corners[0, :, 0], corners[:, 0, 1]  # GPa, K
    assert percent.sum(axis=0) @ (x[1:] + x[:-1]) / 200 == pytest.approx(
        weights.mean() * 1e-9, abs=x[1] - x[0]
    )
    assert percent.sum(axis=1) @ (y[1:] + y[:-1]) / 200 == pytest.approx(
        values.mean(), abs=y[1] - y[0]
    )


def test_the_line_of_the_theory_has_the_heat_share_of_its_points(capped_run, drawn):
    rs.compare(capped_run).chart("a.png")
    line = drawn[0].axes[2].lines[0]
    (speed, value), exact = (
        line.get_data(),
        prediction.predictions(capped_run.scene)["flash_temperature"][2],
    )
    at = np.exp(np.interp(np.log(35.0), np.log(speed), np.log(value)))
    assert at == pytest.approx(0.9 * exact, rel=2e-3)  # interpolated


@pytest.mark.slow
def test_the_calibrated_law_is_a_line_with_a_word_in_the_legend(capped_run, drawn):
    comparison = rs.compare(capped_run)
    comparison.chart("a.png")
    axes = drawn[0].axes
    (row,) = (
        row
        for row in comparison.rows
        if row.observable == "flash_temperature" and row.speed == 35.0
    )
    (line,) = (line for line in axes[2].lines if line.get_color() == CALIBRATED)
    speed, value = line.get_data()
    assert value[list(speed).index(35.0)] == pytest.approx(row.calibrated, rel=1e-9)
    (line,) = (line for line in axes[1].lines if line.get_color() == CALIBRATED)
    (variance,) = (
        row.calibrated for row in comparison.rows if row.observable == "pressure_variance"
    )
    assert line.get_ydata()[0] == pytest.approx(1e-18 * variance, rel=1e-9)
    (legend,) = drawn[0].legends
    words = [text.get_text() for text in legend.get_texts()]
    assert [word for word in words if "calibrated" in word] == [words[1]]
    ((speed, ratio),) = (
        line.get_data() for line in axes[3].lines if line.get_color() == CALIBRATED
    )
    at = list(speed).index(35.0)
    assert ratio[at] == pytest.approx(row.calibrated / row.theory, rel=1e-9)


def test_a_correlation_that_falls_early_is_over_log_r():
    x = np.linspace(0.0, 1.0, 101)
    early = {k: curves._falls_early(Line2D(x, np.exp(-k * x))) for k in (22.0, 24.0)}
    assert early == {22.0: False, 24.0: True}  # e^-2.3 is a tenth


def test_the_profile_runs_along_x_through_the_hottest_point(capped_run):
    one = subject(capped_run, speed=35.0)
    hottest, across, lines = temperature.lines_through_hottest_point(one)
    field = next(capped_run.fields("temperature", speed=35.0))[1]
    assert field[hottest, across] == field.max() == lines["temperature"].max()
    np.testing.assert_array_equal(
        lines["pressure"], next(capped_run.fields("pressure"))[1][:, across]
    )


def test_a_wave_has_its_variance_in_the_measured_spectrum():
    # ⟨h²⟩ = 2π ∫ q C dq: a cosine of amplitude a has a²/2, wherever it lies
    grid = rs.Grid((128, 96), (3e-3, 2e-3))
    x, y = np.meshgrid(np.arange(128) * 3e-3 / 128, np.arange(96) * 2e-3 / 96, indexing="ij")
    q1, q2 = 2 * np.pi * 17 / 3e-3, 2 * np.pi * 9 / 2e-3
    heights = 2e-6 * np.cos(q1 * x + q2 * y + 0.3)
    q = np.geomspace(0.5 * np.hypot(q1, q2), 2 * np.hypot(q1, q2), 4000)
    density = 2 * np.pi * q**2 * spectra.radial_psd(heights, grid, q, (0.0, np.inf))
    assert np.trapezoid(density, np.log(q)) == pytest.approx(
        2e-12, rel=0.05
    )  # few modes near it: their density varies
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
    exact = (full_scene.effective_modulus * q / 2) ** 2 * full_scene.spectrum(
        q
    )  # every wave pressed flat: W = 1
    np.testing.assert_allclose(prediction.stress_spectrum(full_scene, q), exact, rtol=1e-9)


def test_the_stress_spectrum_sums_to_the_variance_of_the_pressure(capped_scene):
    nodes, weights = np.polynomial.legendre.leggauss(400)
    total = 0.0
    for low, high in ((6350.0, 2e4), (2e4, 4e4), (4e4, 2e5)):  # C has a kink at 2e4
        q = np.exp((np.log(high / low) * nodes + np.log(high * low)) / 2)
        density = 2 * np.pi * q**2 * prediction.stress_spectrum(capped_scene, q)
        total += np.log(high / low) / 2 * float(weights @ density)
    assert total == pytest.approx(
        prediction.predictions(capped_scene)["pressure_variance"][0], rel=1e-6
    )


def test_the_measured_stress_spectrum_sums_to_the_measured_variance(capped_run):
    one, axes = subject(capped_run, index=None), Figure().subplots()
    spectra.draw_stress_spectrum(axes, one)
    line = next(
        line
        for line in axes.lines
        if line.get_color() == COLOURS["capped"] and len(line.get_xdata()) > 9
    )
    q, density = line.get_data()
    sample = capped_run.samples("capped")[-1]
    inside = sample.wavenumber < q[-1]
    assert np.trapezoid(density, np.log(q)) == pytest.approx(
        1e-18 * sample.spectrum[:, inside].sum(1).mean(), rel=0.03
    )


def test_profiles_show_their_values(capped_run, drawn):
    plot_run(capped_run, "profile", speed=35.0)
    _, _, lines = temperature.lines_through_hottest_point(subject(capped_run, speed=35.0))
    factors = {"heights": 1e6, "pressure": 1e-9, "temperature": 1.0}
    for axes, (name, factor) in zip(drawn[0].axes, factors.items(), strict=True):
        x, values = axes.lines[0].get_data()
        np.testing.assert_allclose(values, lines[name] * factor, rtol=1e-12)
        np.testing.assert_allclose(x, np.arange(128) * 2.0 / 128)  # mm
    assert [axes.get_ylabel() for axes in drawn[0].axes] == [
        "$h$ (µm)",
        r"$\sigma$ (GPa)",
        "$T$ (K)",
    ]


def test_full_contact_has_the_stress_spectrum_of_the_theory(full_run, drawn):
    # all waves are pressed flat: |σ_q|² = (E*q/2)² C exactly, drawn twice on different ways
    plot_run(full_run, "spectrum")
    theory, measured = drawn[0].axes[1].lines[:2]
    q = np.geomspace(1.2e4, 8e4, 30)
    there = np.interp(q, *measured.get_data()) / np.interp(q, *theory.get_data())
    np.testing.assert_allclose(there, 1.0, atol=0.03)
    q, heights = drawn[0].axes[0].lines[1].get_data()
    far = (
        q > 1.2e4
    )  # nearer to q_min a mode's Fourier cell is wide: its mean exceeds the steep C in the middle
    np.testing.assert_allclose(heights[far], full_run.scene.spectrum(q[far]), rtol=0.03)


# Student at 5 and at 10 degrees of freedom, widened for runs that stop themselves
WIDE, NARROW = 2.5705818 * np.sqrt(1 + 2 / 5), 2.2281389 * np.sqrt(1 + 2 / 10)


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
        assert np.all(
            half >= NARROW * 1e-18 * error * (1 - 1e-6)
        )  # six members of each of two levels
        assert np.all(half <= WIDE * 1e-18 * error * (1 + 1e-6))
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


def densities(values, heat):
    return temperature.densities(
        contact_temperature(np.asarray(values, float), np.asarray(heat, float))
    )


def test_densities_have_the_shares_of_area_and_heat_at_their_temperatures():
    edges, area, heat = densities(
        [[1.0, 2.0], [4.0, 100.0]], [[1.0, 1.0], [2.0, 0.0]]
    )  # 100 K is outside the contact
    width = 3.0 / 80
    np.testing.assert_allclose(edges, 1.0 + width * np.arange(81))
    places = [0, round(1.0 / width), 79]  # of 1 K, 2 K and 4 K
    for density, shares in ((area, [1 / 3, 1 / 3, 1 / 3]), (heat, [0.25, 0.25, 0.5])):
        bins = [
            density[max(place - 1, 0) : place + 1].sum() for place in places
        ]  # 2 K lies on an edge, to rounding
        np.testing.assert_allclose(np.array(bins) * width, 100.0 * np.array(shares))


@pytest.mark.parametrize("values", [[[3.0]], [[300.0, 300.0]], [[1.0, 5.0, 2.0]]])
def test_densities_add_up_to_one_hundred_per_cent(values):
    edges, area, heat = densities(values, np.ones_like(values))
    for density in (area, heat):
        assert (density * np.diff(edges)).sum() == pytest.approx(100.0)
