"""Measured surfaces: reading files of instruments, measuring C(q), and writing heights for other programs.

Files are read through SurfaceTopography, the extra `topography`; writing does not need it. Its C(q) is 4π² larger than
ours: it has ⟨h²⟩ = ∫ C d²q/(2π)², we have ⟨h²⟩ = ∫ C d²q (see `roughsim`).
"""

import warnings
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.errors import RecordError
from roughsim.grid import Array, Field, Grid
from roughsim.surface.power_laws import TabulatedSpectrum
from roughsim.untrusted import check_measured_file, machine_memory

BINS_PER_DECADE = 20
MOST_UNDEFINED = 0.05  # share of points that an instrument may have left out
ENDINGS = (".nc", ".npy")
_ROUNDING = 1e-26  # of the largest C: below it there are rounding errors of the heights alone
_FIRST_BINS = 5  # over which the exponent at the lowest wavenumbers is fitted


@dataclass(frozen=True, slots=True, eq=False)
class Topography:
    """A measured map, detrended."""

    heights: Array  # m, shape `grid.shape`, without mean and, if not periodic, without tilt
    grid: Grid  # its points and lengths
    periodic: bool  # whether it goes on at its edges; else its spectrum is taken under a window
    spectrum: TabulatedSpectrum  # C(q) in Persson's convention, m⁴, averaged over directions


def read_topography(path: str | Path) -> Topography:
    """Read the file of an instrument, detrend the map, and measure its C(q).

    Any format that SurfaceTopography reads will do (x3p, sur, gwy, opd, al3d, nc, …). It must hold a map with its sizes
    and a unit; of several channels the file's default is taken. The map is periodic only if the file says so. Up to 5 %
    of undefined points are filled smoothly, with a RuntimeWarning. ImportError without
    SurfaceTopography, FileNotFoundError without the file, and RecordError, of one line, if the file is refused (see
    `roughsim.untrusted`), cannot be read, or holds no such map.
    """
    path = Path(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ImportWarning)  # it says that there is no MPI
            import SurfaceTopography  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ImportError:
        raise ImportError("SurfaceTopography is not installed; type: pip install 'roughsim[topography]'") from None
    if not path.exists():
        raise FileNotFoundError(f"{path} does not exist; check the path")
    try:
        check_measured_file(path)
        with open(path, "rb") as stream:  # some of its readers would leave the file open
            reader = SurfaceTopography.open_topography(stream)
            _check_channel(path, reader.default_channel)
            measured = reader.topography()
        return _prepared(path, measured.to_unit("m"))
    except RecordError:
        raise
    except Exception as error:  # forty readers of binary formats, each with its own failures
        reason = " ".join(str(error).split())[:200]
        raise RecordError(f"{path} cannot be read as a map of heights ({type(error).__name__}: {reason})") from error


def _check_channel(path: Path, channel: Any) -> None:
    """Refuse what is no map of known size, before its heights are read."""
    if channel.dim != 2:
        raise RecordError(f"{path} holds a line scan; C(q) of a surface needs a map")
    if min(channel.nb_grid_pts) < 8:
        raise RecordError(f"{path} has {channel.nb_grid_pts} points; C(q) needs at least 8 along each side")
    if channel.physical_sizes is None or channel.unit is None:
        missing = "size" if channel.physical_sizes is None else "unit"
        raise RecordError(f"{path} does not say its {missing}; save it as x3p or nc, which do")
    points = float(np.prod([float(n) for n in channel.nb_grid_pts]))
    if 64.0 * points > 0.5 * machine_memory():
        raise RecordError(
            f"{path} declares {points:.3g} points; it takes {64e-9 * points:.3g} GB to read, above half of the "
            "machine's memory; crop it"
        )


def _prepared(path: Path, measured: Any) -> Topography:
    if measured.has_undefined_data:
        share = float(np.mean(np.ma.getmaskarray(measured.heights())))
        if share > MOST_UNDEFINED:
            raise RecordError(
                f"{path}: {100 * share:.3g} % of its points are undefined, above {100 * MOST_UNDEFINED:g} %; crop it, "
                f"or fill them with the program of the instrument"
            )
        warnings.warn(f"{path}: undefined points, {100 * share:.2g} %, were filled", RuntimeWarning, stacklevel=3)
        measured = measured.interpolate_undefined_data()
    periodic = bool(measured.is_periodic)
    flat = measured.detrend("center" if periodic else "rms-tilt")
    heights = np.ascontiguousarray(flat.heights(), dtype=np.float64)
    if not np.isfinite(heights).all() or not np.ptp(heights) > 0.0:
        raise RecordError(f"{path} holds heights that are not finite, or all alike; there is no C(q) to measure")
    lengths = (float(flat.physical_sizes[0]), float(flat.physical_sizes[1]))
    grid = Grid((heights.shape[0], heights.shape[1]), lengths)
    # C(q) in our convention, under a Hann window unless the map is periodic, up to where the instrument is reliable
    *_, theirs = flat.power_spectrum_from_area(return_map=True)
    cutoff = flat.short_reliability_cutoff()
    reliable = np.inf if cutoff is None else 2 * np.pi / float(cutoff)
    spectrum = radial_average(np.asarray(theirs) / (4 * np.pi**2), grid, min(grid.nyquist, reliable))
    return Topography(heights, grid, periodic, spectrum)


def radial_average(psd: Array, grid: Grid, q_max: float) -> TabulatedSpectrum:
    """Average C(q⃗) over directions, in bins of log q.

    Within a bin C(q) is taken as the power law of its neighbours, so that the value at its centre is not raised by its
    lower edge. Below the first bin C(q) goes on as the power law of the first bins, to where the variance of all modes
    is reached: the modes of a cell stand for what is shorter than its sides, and ⟨h²⟩ is kept.

    `psd` is C(q⃗), m⁴, at the wavevectors of the discrete transform of `grid`, ∫ C d²q = ⟨h²⟩; `q_max` is where to end,
    rad/m. ValueError if fewer than three bins hold modes.
    """
    # all modes but q = 0, up to q_max or to where a synthetic map ends
    k = np.arange(grid.shape[1])
    q = grid.wavenumbers[:, np.minimum(k, grid.shape[1] - k)]
    present = psd > _ROUNDING * psd[q > 0.0].max()
    inside = (q > 0.0) & (q <= min(q_max, float(q[present].max())) * (1 + 1e-12))
    q, values = q[inside], psd[inside]
    # their bins, in log q
    first, q_max = float(q.min()), float(q.max())
    bins = max(3, int(np.ceil(BINS_PER_DECADE * np.log10(q_max / first))))
    edges = np.geomspace(first * (1 - 1e-9), q_max * (1 + 1e-9), 1 + bins)
    which = np.digitize(q, edges) - 1
    count = np.bincount(which, minlength=edges.size - 1)
    filled = count > 0
    if filled.sum() < 3:
        raise ValueError(f"only {filled.sum()} bins of wavenumbers up to q_max = {q_max:.4g} rad/m hold modes")
    # the mean of each bin is made the value at its centre, by the power law of its neighbours
    centre = np.exp(np.bincount(which, np.log(q))[filled] / count[filled])
    mean = np.bincount(which, values)[filled] / count[filled]
    exponent = -np.gradient(np.log(mean), np.log(centre))
    own = np.cumsum(filled)[which] - 1  # the bin of each mode among the filled ones
    shape = (q / centre[own]) ** -exponent[own]  # of the power law over the bin, 1 at its centre
    level = mean / (np.bincount(which, shape)[filled] / count[filled])
    cell = 4 * np.pi**2 / (grid.lengths[0] * grid.lengths[1])
    return _with_ends(centre, level, float(values.sum()) * cell, q_max)


def _with_ends(q: Array, psd: Array, variance: float, q_max: float) -> TabulatedSpectrum:
    """The table, carried on to q_max and, below its first row, to where 2π∫qC dq is the variance of the modes."""
    if q[-1] < q_max * (1 - 1e-6):
        slope = np.log(psd[-1] / psd[-2]) / np.log(q[-1] / q[-2])
        q, psd = np.append(q, q_max), np.append(psd, psd[-1] * (q_max / q[-1]) ** slope)
    table = TabulatedSpectrum(q, psd)
    missing = variance - table.moment(0)
    if missing <= 0.0:
        return table
    lowest = slice(0, _FIRST_BINS)
    exponent = float(np.clip(-np.polyfit(np.log(q[lowest]), np.log(psd[lowest]), 1)[0], 0.0, 4.0))
    # 2π ∫ q C dq from q_low to q₁ = 2π C₁ q₁² (1 − (q_low/q₁)^p)/p, p = 2 − exponent, log for p = 0
    share, power = missing / (2 * np.pi * psd[0] * q[0] ** 2), 2.0 - exponent
    inner = max(1.0 - share * power, 0.0)
    ratio = np.exp(-share) if abs(power) < 1e-9 else (inner ** (1.0 / power) if inner > 0.0 else 0.0)
    q_low = q[0] * float(np.clip(ratio, 0.4, 1.0))  # a mode at 2π/L stands for no wave longer than about 2L
    if q_low > 0.999 * q[0]:
        return table
    return TabulatedSpectrum(np.append(q_low, q), np.append(psd[0] * (q[0] / q_low) ** exponent, psd))


def encoded(heights: Field, grid: Grid, ending: str) -> bytes:
    """Return the content of a file that SurfaceTopography, ContactMechanics and tamaas can start from.

    `heights` are in m, shape `grid.shape`. The ending ".nc" is classic netCDF with sizes, unit and periodicity, as
    ``SurfaceTopography.read_topography`` (and so ContactMechanics) takes it; ".npy" the bare array, for ``numpy.load``
    and so for tamaas. ValueError for another ending, or heights of another shape.
    """
    if ending not in ENDINGS:
        raise ValueError(f"ending = {ending!r} is no format of a surface; use {' or '.join(ENDINGS)}")
    data, stream = np.asarray(heights, dtype=np.float64), BytesIO()
    if data.shape != grid.shape:
        raise ValueError(f"heights has shape {data.shape}, but the grid has {grid.shape}")
    if ending == ".npy":
        np.save(stream, data, allow_pickle=False)
        return stream.getvalue()
    from scipy.io import netcdf_file

    file = netcdf_file(stream, "w", version=2)
    for axis, points, length in zip("xy", grid.shape, grid.lengths, strict=True):
        file.createDimension(axis, points)
        variable: Any = file.createVariable(axis, "d", (axis,))
        variable[:] = np.arange(points) * (length / points)
        variable.length = np.float64(length)  # a bare float would be stored in single precision
        variable.periodic, variable.unit, variable.units = 1, "m", "m"
    variable = file.createVariable("heights", "d", ("x", "y"))
    variable[:] = data
    variable.unit = variable.units = "m"
    file.flush()
    content = stream.getvalue()
    file.close()  # and the stream with it
    return content
