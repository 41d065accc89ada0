"""Spectra of the heights and of the stress, and the stress correlation, over the lines of the theory."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from roughsim import fourier, prediction
from roughsim.charts.style import COLOURS, MARKERS, THEORY, Array, band, new_figure, save, statistical
from roughsim.estimate.errors import quantile, spread
from roughsim.results.fields import kept, member_field

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from roughsim.charts.pictures import Subject
    from roughsim.grid import Grid

_WIDTH = 0.06  # of the Gaussian in ln q that spectra are averaged with


def spectrum_chart(subject: Subject, path: Path) -> None:
    """Draw the measured C(q) of kept heights over C(q) and C_sm(q), and the stress spectrum over the theory's."""
    with new_figure(path, (9.6, 4.4)) as figure:
        left, right = figure.subplots(1, 2)
        _heights(left, subject)
        _stress(right, subject)
        title = subject.title("Power spectra of the heights and of the contact stress")
        figure.suptitle(title, fontsize=9, x=0.01, ha="left")
        save(figure, path)


def _heights(axes: Axes, subject: Subject) -> None:
    run, grid = subject.run, subject.run.numerics.grid(subject.level)
    half = np.pi * np.sqrt(2.0) / min(grid.lengths)  # modes whose Fourier cell lies inside the band as a whole
    band_ends = run.scene.spectrum.breaks[0] + half, run.numerics.levels[subject.level].q_max - half
    q = _wavenumbers(*band_ends)
    indices = kept(run, subject.level) if subject.index is None else [subject.index]
    rows = np.array([radial_psd(member_field(run, subject.level, i, "heights"), grid, q, band_ends) for i in indices])
    dense = np.geomspace(run.scene.spectrum.breaks[0], run.scene.spectrum.breaks[-1], 400)
    axes.loglog(dense, run.scene.spectrum(dense), color=THEORY, lw=1.3, label="$C(q)$")
    if not run.scene.elastic:
        smooth = prediction.smoothed_spectrum(run.scene)(dense)
        low = 0.1 * float(run.scene.spectrum(dense[-1]))
        style: Any = {"color": THEORY, "lw": 1.1, "ls": "--", "label": r"$C_\mathrm{sm}(q)$, theory"}
        axes.loglog(dense, np.where(smooth > low, smooth, np.nan), **style)
    count = f"{len(indices)} kept surface" + ("s" if len(indices) > 1 else "")
    colour: Any = {"color": COLOURS[subject.column], "marker": MARKERS[subject.column]}
    axes.loglog(q[::2], rows.mean(axis=0)[::2], ls="", ms=3, **colour, label=f"measured, {count}")
    axes.set(xlabel="$q$, rad/m", ylabel="$C$, m⁴", title="Roughness")
    _ends(axes, subject)
    axes.legend(loc="upper right", bbox_to_anchor=(1.0, 0.92))


def _stress(axes: Axes, subject: Subject) -> None:
    run, grid = subject.run, subject.run.numerics.grid(subject.level)
    q = _wavenumbers(2 * np.pi / max(grid.lengths), grid.nyquist)
    sample = run.samples(subject.column)[-1]
    spectra = sample.spectrum if subject.index is None else sample.spectrum[[_row(subject)]]
    kernel = _kernel(q, sample.wavenumber)
    rows = spectra @ kernel.T / _modes(grid, q, (0.0, np.inf))
    weight = 2 * np.pi * q**2 * 1e-18
    mean = rows.mean(axis=0)
    error = quantile(len(rows) - 1.0) * spread(rows)[0] if len(rows) > 1 else 0.0 * q
    dense = np.geomspace(run.scene.spectrum.breaks[0], run.scene.spectrum.breaks[-1], 400)
    theory = 2 * np.pi * dense**2 * prediction.stress_spectrum(run.scene, dense) * 1e-18
    axes.loglog(dense, theory, color=THEORY, lw=1.3, label=rf"theory, $\gamma$ = {run.scene.theory.gamma:g}")
    band(axes, q, mean * weight, error * weight, COLOURS[subject.column])
    count = f"{len(rows)} realizations, band: statistical, 95 %" if len(rows) > 1 else f"realization {subject.index}"
    axes.plot([], [], color=COLOURS[subject.column], label=f"measured, {count}")
    top = max(float(theory.max()), float((mean * weight).max()))
    axes.set(xlabel="$q$, rad/m", ylabel=r"$2\pi q^2 |\sigma_q|^2$, GPa² per $\ln q$", ylim=(1e-5 * top, 30 * top))
    axes.set_title("Stress: its variance by wavenumber")
    axes.set_xlim(0.8 * q[0], 2 * q[-1])
    _ends(axes, subject)
    axes.legend(loc="upper left")


def _row(subject: Subject) -> int:
    return subject.run.sound(subject.run.realizations).index(subject.index or 0)


def _ends(axes: Axes, subject: Subject) -> None:
    """The cut-off q_c of the level."""
    end = subject.run.numerics.levels[subject.level].q_max
    axes.axvline(end, color=COLOURS[subject.column], lw=0.8, ls=":")
    axes.text(end, 0.98, " $q_c$", transform=axes.get_xaxis_transform(), va="top", color=COLOURS[subject.column])


def _wavenumbers(first: float, last: float) -> Array:
    """Where spectra are drawn: evenly in ln q, half a width inside the ends."""
    first, last = first * (1 + _WIDTH / 2), last * (1 - _WIDTH / 2)
    return np.geomspace(first, last, max(8, round(np.log(last / first) / _WIDTH)))


def radial_psd(heights: Any, grid: Grid, q: Array, ends: tuple[float, float]) -> Array:
    """Return the measured C(q), m⁴: |h(q)|² over the area of a mode in the plane of wavevectors, averaged around |q|.

    The mean is over the modes between `ends`, rad/m, with Gaussian weights in ln q; |h(q)|² q⁴ is what is averaged, so
    that a steep spectrum is not bent by its own mean.
    """
    power = np.abs(fourier.forward(np.ascontiguousarray(heights, dtype=np.float64))) ** 2 * grid.multiplicity
    return _binned(grid, q, power * grid.wavenumbers**4, ends) / _modes(grid, q, ends) / q**4


def _modes(grid: Grid, q: Array, ends: tuple[float, float]) -> Array:
    """The area of the modes near each q in the plane of wavevectors, weighted as the spectra are, 1/m²."""
    cell = 4 * np.pi**2 / (grid.lengths[0] * grid.lengths[1])
    return cell * _binned(grid, q, np.broadcast_to(grid.multiplicity, grid.half_shape), ends)


def _binned(grid: Grid, q: Array, values: Array, ends: tuple[float, float]) -> Array:
    """Σ of `values` over the modes between `ends` with the weights of `_kernel`, through narrow bins of ln q."""
    wavenumbers = grid.wavenumbers
    present = (wavenumbers > 0.0) & (wavenumbers >= ends[0] * (1 - 1e-9)) & (wavenumbers <= ends[1] * (1 + 1e-9))
    step = _WIDTH / 16
    place = np.rint(np.log(wavenumbers[present]) / step).astype(np.intp)
    low = int(place.min())
    sums = np.bincount(place - low, np.asarray(values)[present])
    result: Array = _kernel(q, np.exp(step * (low + np.arange(sums.size)))) @ sums
    return result


def _kernel(q: Array, entries: Array) -> Array:
    """Gaussian weights of spectral entries around each q, shape (q, entries)."""
    result: Array = np.exp(-0.5 * (np.subtract.outer(np.log(q), np.log(entries)) / _WIDTH) ** 2)
    return result


def correlation_chart(subject: Subject, path: Path) -> None:
    """Draw g_σ(r) of all realizations with its band over the theory, near and far."""
    run = subject.run
    longest = 2 * np.pi / run.scene.spectrum.breaks[0]
    reach = 0.5 * float(np.hypot(*run.numerics.lengths))
    near = np.geomspace(1e-4 * longest, 0.4 * min(longest, reach / 0.4), 160)
    with new_figure(path, (9.6, 4.2)) as figure:
        left, right = figure.subplots(1, 2)
        _correlation(left, subject, near)
        left.set(xscale="log", title="From the smallest distances", xlim=(near[0] * 1e6, near[-1] * 1e6))
        far = np.linspace(0.0, min(1.2 * longest, reach), 240)
        _correlation(right, subject, far)
        values = np.concatenate([line.get_ydata() for line in right.lines[:2]])
        right.set(
            title="Far: where it is negative", xlim=(0, far[-1] * 1e6), ylim=(1.2 * values.min(), 0.1 * values.max())
        )
        count = len(run.sound(run.realizations))
        right.legend(loc="upper right", title=f"{count} realizations, band: statistical, 95 %", alignment="left")
        title = subject.title(r"Correlation of the contact stress, $g_\sigma(r)$")
        figure.suptitle(title, fontsize=9, x=0.01, ha="left")
        save(figure, path)


def _correlation(axes: Axes, subject: Subject, r: Array) -> None:
    run = subject.run
    theory = prediction.correlation(run.scene, r)
    axes.plot(r * 1e6, theory * 1e-18, color=THEORY, lw=1.3, label=rf"theory, $\gamma$ = {run.scene.theory.gamma:g}")
    mean, error = run.correlation(r, subject.column)
    band(axes, r * 1e6, mean * 1e-18, statistical(run, subject.column, error) * 1e-18, COLOURS[subject.column])
    axes.plot([], [], color=COLOURS[subject.column], label=f"{subject.column} contact")
    axes.axhline(0.0, color="0.7", lw=0.6, zorder=0)
    axes.set(xlabel="$r$, µm", ylabel=r"$g_\sigma$, GPa²")
