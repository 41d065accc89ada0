"""Reading maps of heights: formats of instruments through SurfaceTopography, plain numbers by NumPy."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from roughsim.errors import RecordError
from roughsim.grid import Array, Grid
from roughsim.machine import exceeds
from roughsim.surface.power_laws import TabulatedSpectrum
from roughsim.surface.topography.measured import Bins, MeasuredSpectrum, combined, map_spectrum
from roughsim.surface.topography.texture import Texture, texture_of
from roughsim.untrusted import check_measured_file

MOST_UNDEFINED = 0.05  # share of points that an instrument may have left out
LEAST_POINTS = 8  # along each side
BYTES_PER_POINT = 64.0  # that reading a map and its C(q) take
PLAIN = (".txt", ".csv", ".npy")  # files of numbers alone, without size and unit


@dataclass(frozen=True, eq=False)
class Topography:
    """A measured map, detrended."""

    heights: Array  # m, shape `grid.shape`, without mean and, if not periodic, without tilt
    grid: Grid  # its points and lengths
    periodic: bool  # whether it goes on at its edges; else its spectrum is taken under a window
    reliable: float = np.inf  # wavenumber up to which the instrument resolves, rad/m

    @cached_property
    def bins(self) -> Bins:
        """C(q), averaged over directions and bins of log q."""
        return map_spectrum(self.heights, self.grid, periodic=self.periodic, reliable=self.reliable)

    @cached_property
    def texture(self) -> Texture:
        """The lay of its slopes, and how far its heights are from Gaussian ones."""
        return texture_of(self.heights, self.grid, periodic=self.periodic, reliable=self.reliable)

    @property
    def measured(self) -> MeasuredSpectrum:
        """C(q) with its error."""
        return combined([self.bins])

    @property
    def spectrum(self) -> TabulatedSpectrum:
        """C(q) in Persson's convention, m⁴, averaged over directions."""
        return self.measured.spectrum


class Read(NamedTuple):
    """What a file says."""

    heights: Array  # m, NaN where undefined
    lengths: tuple[float, float]  # m
    periodic: bool
    reliable: float  # wavenumber up to which the instrument resolves, rad/m


def library() -> Any:
    """Return SurfaceTopography; ImportError that says what to type without it."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ImportWarning)  # it says that there is no MPI
            import SurfaceTopography  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ImportError:
        raise ImportError("SurfaceTopography is not installed; type: pip install 'roughsim[topography]'") from None
    return SurfaceTopography


def is_plain(path: str | Path) -> bool:
    """Return whether a file holds numbers alone, by its ending."""
    return Path(path).suffix.lower() in PLAIN


def read_topography(path: str | Path, *, size: Sequence[float] | None = None, unit: float | None = None) -> Topography:
    """Read a map of heights, fill what is missing, and take mean and tilt off.

    .txt, .csv and .npy are numbers alone: row k of the array, or line k of the text, has the heights at the k-th point
    along x. They need `size` and `unit`. Any other format is read by SurfaceTopography (x3p, sur, gwy, opd, al3d, nc,
    …); it must hold a map with its size and unit. Of several channels the file's default is taken. The map is periodic
    only if the file says so. Up to 5 % of undefined points are filled smoothly by SurfaceTopography, with a
    RuntimeWarning.

    Parameters
    ----------
    path : str or Path
        The file.
    size : (float, float), optional
        Side lengths along x and y, m, of a file that does not say them.
    unit : float, optional
        Unit of the heights, m, of a file that does not say it.

    Raises
    ------
    ImportError
        Without SurfaceTopography, where it is needed.
    FileNotFoundError
        Without the file.
    RecordError
        Of one line, if the file is refused (see `roughsim.untrusted`), cannot be read, or holds no such map.
    """
    path = Path(path)
    plain = is_plain(path)
    if not plain:
        library()
    if not path.exists():
        raise FileNotFoundError(f"{path} does not exist; check the path")
    if plain != (size is not None) or plain != (unit is not None):
        raise RecordError(
            f"{path} holds numbers alone and needs topography_size and topography_unit, or save it as x3p or nc"
            if plain
            else f"{path} says its size and unit itself; remove topography_size and topography_unit"
        )
    try:
        check_measured_file(path)
        found = _of_instrument(path) if size is None or unit is None else _plain(path, (size[0], size[1]), unit)
    except RecordError:
        raise
    except Exception as error:  # forty readers of binary formats, each with its own failures
        reason = " ".join(str(error).split())[:200]
        raise RecordError(f"{path} cannot be read as a map of heights ({type(error).__name__}: {reason})") from error
    heights = _filled(path, found.heights, found.lengths)
    if not np.ptp(heights) > 0.0:
        raise RecordError(f"{path} holds heights that are all alike; there is no C(q) to measure")
    grid = Grid((heights.shape[0], heights.shape[1]), found.lengths)
    return Topography(levelled(heights, found.periodic), grid, found.periodic, found.reliable)


def _check_points(path: Path, shape: tuple[int, ...]) -> None:
    """Refuse what is no map, or too small or too large a one, before its heights are read."""
    if len(shape) != 2:
        raise RecordError(f"{path} holds {'a line scan' if len(shape) == 1 else shape}; C(q) of a surface needs a map")
    if min(shape) < LEAST_POINTS:
        raise RecordError(f"{path} has {shape} points; C(q) needs at least {LEAST_POINTS} along each side")
    points = float(np.prod([float(n) for n in shape]))
    if exceeds(BYTES_PER_POINT * points, 0.5):
        raise RecordError(
            f"{path} declares {points:.3g} points; it takes {1e-9 * BYTES_PER_POINT * points:.3g} GB to read, above "
            "half of the available memory; crop it"
        )


def _of_instrument(path: Path) -> Read:
    """Read a format of an instrument."""
    with open(path, "rb") as stream:  # some of its readers would leave the file open
        reader = library().open_topography(stream)
        channel = reader.default_channel
        _check_points(path, tuple(channel.nb_grid_pts) if channel.dim == 2 else (channel.nb_grid_pts[0],))
        if channel.physical_sizes is None or channel.unit is None:
            missing = "size" if channel.physical_sizes is None else "unit"
            raise RecordError(f"{path} does not say its {missing}; save it as x3p or nc, which do")
        measured = reader.topography().to_unit("m")
    heights = np.ma.filled(np.ma.asarray(measured.heights(), dtype=np.float64), np.nan)
    cutoff = measured.short_reliability_cutoff()
    x, y = measured.physical_sizes
    return Read(
        np.ascontiguousarray(heights),
        (float(x), float(y)),
        bool(measured.is_periodic),
        np.inf if cutoff is None else 2 * np.pi / float(cutoff),
    )


def _plain(path: Path, lengths: tuple[float, float], unit: float) -> Read:
    """Read numbers alone; what is not finite is undefined."""
    if path.suffix.lower() == ".npy":
        numbers = np.load(path, mmap_mode="r", allow_pickle=False)
        if numbers.dtype.kind not in "uif":
            raise RecordError(f"{path} holds an array of dtype {numbers.dtype}; heights must be real numbers")
    else:
        numbers = _numbers_of_text(path)
    _check_points(path, numbers.shape)
    heights = unit * np.array(numbers, dtype=np.float64)
    heights[~np.isfinite(heights)] = np.nan
    return Read(heights, lengths, False, np.inf)


def _numbers_of_text(path: Path) -> Array:
    """Return the numbers of a text file, divided by commas, semicolons or blanks; lines with # are comments."""
    text = path.read_bytes().decode("utf-8-sig", errors="replace")
    first = next((line for line in text.splitlines() if line.split("#")[0].strip()), "")
    delimiter = next((sign for sign in ",;" if sign in first), None)
    if not first:
        raise RecordError(f"{path} holds no numbers; is it the right file?")
    try:
        return np.loadtxt(StringIO(text), delimiter=delimiter, ndmin=2)
    except ValueError as error:
        reason = str(error).split("; use `usecols`")[0].rstrip(".")
        raise RecordError(f"{path} must hold numbers alone, as many in each line, divided alike: {reason}") from None


def _filled(path: Path, heights: Array, lengths: tuple[float, float]) -> Array:
    """Return the heights with undefined points filled smoothly, if they are few."""
    undefined = np.isnan(heights)
    share = float(np.mean(undefined))
    if share == 0.0:
        return heights
    if share > MOST_UNDEFINED:
        raise RecordError(
            f"{path}: {100 * share:.3g} % of its points are undefined, above {100 * MOST_UNDEFINED:g} %; crop it, "
            f"or fill them with the program of the instrument"
        )
    warnings.warn(f"{path}: undefined points, {100 * share:.2g} %, were filled", RuntimeWarning, stacklevel=3)
    masked = library().Topography(np.ma.masked_array(heights, undefined), lengths, unit="m")
    return np.ascontiguousarray(masked.interpolate_undefined_data().heights(), dtype=np.float64)


def levelled(heights: Array, periodic: bool = False) -> Array:
    """Return the heights without their mean, and without the plane of least squares if they are not periodic."""
    heights = heights - heights.mean()
    if not periodic:
        for axis, points in enumerate(heights.shape):
            along = np.arange(points) - 0.5 * (points - 1)
            slope = float(np.mean(heights, axis=1 - axis) @ along / (along @ along))
            heights -= slope * (along[:, None] if axis == 0 else along)
    return heights
