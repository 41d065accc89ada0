"""Spectra of the heights and of the stress, and the stress correlation, over the lines of the theory."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from roughsim import fourier, prediction
from roughsim.charts.style import COLOURS, MARKERS, THEORY, Subject, band, new_figure, row_of_panels
from roughsim.estimate.errors import half_width, spread, spread_of
from roughsim.estimate.telescoping import correlation_of
from roughsim.grid import Array, Grid, modes_between
from roughsim.results.run import Run
from roughsim.scene import Scene

_WIDTH = 0.06  # of the Gaussian weights in ln q that average the spectra


def spectrum_chart(subject: Subject, path: Path) -> None:
    """Draw the measured C(q) of kept heights over C(q) and C_sm(q), and the stress spectrum over the theory's."""
    title = subject.title("Power spectra of the heights and of the contact stress")
    with new_figure(path, (9.6, 4.4), title, subject.look) as figure:
        left, right = row_of_panels(figure, 2)
        _draw_roughness(left, subject)
        draw_stress_spectrum(right, subject)
        cut, colour = subject.run.numerics.levels[subject.level].q_max, COLOURS[subject.column]
        for axes in (left, right):  # the cut-off of the level
            axes.axvline(cut, color=colour, lw=0.8, ls=":")
            axes.text(
                cut, 0.98, " $q_c$", transform=axes.get_xaxis_transform(), va="top", color=colour
            )
        left.legend(loc="lower left")
        right.legend(loc="upper left")


def _draw_roughness(axes: Axes, subject: Subject) -> None:
    """Draw C(q), the theory's C_sm(q), and the mean C(q) of the kept surfaces."""
    run, spectrum = subject.run, subject.run.scene.spectrum
    grid = run.numerics.grid(subject.level)  # before its lay stretches the surface
    draw_psd(axes, run.scene, 1.3)
    # modes whose Fourier cell lies inside the band as a whole
    half = np.pi * np.sqrt(2.0) / min(grid.lengths)
    ends = spectrum.breaks[0] + half, run.numerics.levels[subject.level].q_max - half
    q = _drawn_wavenumbers(*ends)
    indices = run.kept(subject.level) if subject.index is None else [subject.index]
    surfaces = (run.field(subject.level, index, "heights") for index in indices)
    mean = np.mean([radial_psd(heights, grid, q, ends) for heights in surfaces], axis=0)
    label = f"measured, {len(indices)} kept surface" + ("s" if len(indices) > 1 else "")
    marker, colour = MARKERS[subject.column], COLOURS[subject.column]
    axes.loglog(q[::2], mean[::2], ls="", ms=3, color=colour, marker=marker, label=label)
    axes.set(xlabel="$q$ (rad/m)", ylabel="$C$ (m⁴)", title="Roughness")


def draw_stress_spectrum(axes: Axes, subject: Subject) -> None:
    """Draw 2π q² |σ_q|², the variance of the pressure per ln q, measured and in the theory."""
    run, colour = subject.run, COLOURS[subject.column]
    q = _drawn_wavenumbers(2 * np.pi / max(subject.grid.lengths), subject.grid.nyquist)
    sample = next(one for one in run.samples(subject.column) if one.level == subject.level)
    spectra, one = sample.spectrum, "one realization"
    if subject.index is not None:
        spectra, one = spectra[sample.rows == subject.index], f"realization {subject.index}"
    # the variance of the modes near each q over their area in the plane of wavevectors
    rows = spectra @ _weights(q, sample.wavenumber).T / _mode_area(subject.grid, q, (0.0, np.inf))
    density = 2 * np.pi * q**2 * 1e-18
    mean = rows.mean(axis=0) * density
    error = half_width(*spread(rows)) * density if len(rows) > 1 else 0.0 * q
    dense = np.geomspace(run.scene.spectrum.breaks[0], run.scene.spectrum.breaks[-1], 400)
    theory = 2 * np.pi * dense**2 * prediction.stress_spectrum(run.scene, dense) * 1e-18
    axes.loglog(
        dense, theory, color=THEORY, lw=1.3, label=rf"theory, $\gamma$ = {run.scene.theory.gamma:g}"
    )
    band(axes, q, mean, error, colour)
    count = f"{len(rows)} realizations,\nband: statistical, 95 %" if len(rows) > 1 else one
    axes.plot([], [], color=colour, label=f"measured, {count}")
    top = max(float(theory.max()), float(mean.max()))
    axes.set(
        xlabel="$q$ (rad/m)",
        ylabel=r"$2\pi q^2 |\sigma_q|^2$ (GPa² per $\ln q$)",
        ylim=(1e-5 * top, 30 * top),
        title="Stress: its variance by wavenumber",
        xlim=(0.8 * q[0], 2 * q[-1]),
    )


def draw_cut_offs(axes: Axes, run: Run, colour: str | None) -> None:
    """Draw the cut-offs q_c of all levels of a run, in the colours of their columns if no colour is given."""
    for column in run.numerics.columns:
        for cut_off in {sample.q_max for sample in run.samples(column)}:
            axes.axvline(cut_off, color=colour or COLOURS[column], lw=1.0, ls=":")


def draw_psd(axes: Axes, scene: Scene, width: float, colour: str = THEORY) -> None:
    """Draw C(q) and, dashed, C_sm(q) down to a tenth of the smallest C(q)."""
    spectrum = scene.spectrum
    q = np.geomspace(spectrum.breaks[0], spectrum.breaks[-1], 400)
    axes.loglog(q, spectrum(q), color=colour, lw=width, label="$C(q)$")
    if not scene.elastic:
        smoothed = prediction.smoothed_spectrum(scene)(q)
        drawn = np.where(smoothed > 0.1 * float(spectrum(q[-1])), smoothed, np.nan)
        axes.loglog(
            q, drawn, color=colour, lw=width - 0.2, ls="--", label=r"$C_\mathrm{sm}(q)$, theory"
        )


def draw_correlation(
    axes: Axes, run: Run, column: str, r: Array, colour: str | None = None, name: str = "measured"
) -> None:
    """Draw the measured g_σ(r), r in m, with its 95 % interval; `name` as of `band`."""
    mean = correlation_of(run.samples(column), r)
    error = half_width(*spread_of(mean))
    band(axes, r * 1e6, mean.value * 1e-18, error * 1e-18, colour or COLOURS[column], name)


def _drawn_wavenumbers(first: float, last: float) -> Array:
    """Return the wavenumbers at which spectra are drawn, rad/m: even in ln q, half a width inside the ends."""
    first, last = first * (1 + _WIDTH / 2), last * (1 - _WIDTH / 2)
    return np.geomspace(first, last, max(8, round(np.log(last / first) / _WIDTH)))


def radial_psd(heights: NDArray[Any], grid: Grid, q: Array, ends: tuple[float, float]) -> Array:
    """Return the measured C(q), m⁴: |h(q)|² over the area of a mode in the plane of wavevectors, averaged around |q|.

    The mean is over the modes between `ends`, rad/m, with Gaussian weights in ln q. It is taken of |h(q)|² q⁴, which
    avoids a bias of steep spectra.
    """
    power = np.abs(fourier.forward(np.ascontiguousarray(heights, dtype=np.float64))) ** 2
    return _sum_near(grid, q, power * grid.wavenumbers**4, ends) / _mode_area(grid, q, ends) / q**4


def _mode_area(grid: Grid, q: Array, ends: tuple[float, float]) -> Array:
    """Return the area of the modes near each q in the plane of wavevectors, weighted as the spectra are, 1/m²."""
    cell = 4 * np.pi**2 / (grid.lengths[0] * grid.lengths[1])
    return cell * _sum_near(grid, q, np.ones(grid.half_shape), ends)


def _sum_near(grid: Grid, q: Array, values: Array, ends: tuple[float, float]) -> Array:
    """Return the sum of values over the modes near each q and between `ends`, with Gaussian weights in ln q."""
    modes = modes_between(grid, *ends)
    # sum the modes in bins much narrower than the weights first: a weight for each pair of mode and q would be too many
    step = _WIDTH / 16
    bins = np.rint(np.log(modes.wavenumber) / step).astype(np.intp)
    first = int(bins.min())
    sums = np.bincount(bins - first, modes.multiplicity * values[modes.chosen])
    result: Array = _weights(q, np.exp(step * (first + np.arange(sums.size)))) @ sums
    return result


def _weights(q: Array, wavenumbers: Array) -> Array:
    """Return the Gaussian weights in ln q of wavenumbers around each q, shape (q, wavenumbers)."""
    result: Array = np.exp(-0.5 * (np.subtract.outer(np.log(q), np.log(wavenumbers)) / _WIDTH) ** 2)
    return result


def correlation_chart(subject: Subject, path: Path) -> None:
    """Draw g_σ(r) of all realizations with its band over the theory, at short and at long distances."""
    run, scene = subject.run, subject.run.scene
    longest = 2 * np.pi / scene.spectrum.breaks[0]
    reach = 0.5 * float(np.hypot(*run.sides))
    near = np.geomspace(1e-4 * longest, 0.4 * min(longest, reach / 0.4), 160)
    far = np.linspace(0.0, min(1.2 * longest, reach), 240)
    title = subject.title(r"Correlation of the contact stress, $g_\sigma(r)$")
    with new_figure(path, (9.6, 4.2), title, subject.look) as figure:
        left, right = row_of_panels(figure, 2)
        for axes, r in ((left, near), (right, far)):
            label = rf"theory, $\gamma$ = {scene.theory.gamma:g}"
            axes.plot(
                r * 1e6, prediction.correlation(scene, r) * 1e-18, color=THEORY, lw=1.3, label=label
            )
            draw_correlation(axes, run, subject.column, r)
            axes.plot([], [], color=COLOURS[subject.column], label=f"{subject.column} contact")
            axes.axhline(0.0, color="0.7", lw=0.6, zorder=0)
            axes.set(xlabel="$r$ (µm)", ylabel=r"$g_\sigma$ (GPa²)")
        left.set(
            xscale="log", title="From the smallest distances", xlim=(near[0] * 1e6, near[-1] * 1e6)
        )
        values = np.concatenate([line.get_ydata() for line in right.lines[:2]])
        right.set(title="Long distances: negative part", xlim=(0, far[-1] * 1e6))
        right.set_ylim(1.2 * np.nanmin(values), 0.1 * np.nanmax(values))
        count = len(run.samples(subject.column)[0].rows)
        title = f"{count} realizations of the lowest level,\nband: statistical, 95 %"
        title = title if count > 1 else "one realization of the lowest level"
        right.legend(loc="upper right", title=title, alignment="left")
