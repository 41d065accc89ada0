"""Reading maps of heights and line scans: by their content, whatever the name of the file."""

import warnings
from collections import defaultdict
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from roughsim.errors import RecordError
from roughsim.grid import Array, Grid
from roughsim.surface.directions import Directions, measured_directions
from roughsim.surface.topography.contents import Contents, NoHeightsError, check_points
from roughsim.surface.topography.instruments import (
    TIFF,
    library,
    no_map,
    of_instrument,
    of_tiff,
    unknown,
)
from roughsim.surface.topography.measured import (
    BinnedSpectrum,
    levelled,
    map_spectrum,
    window_share,
)
from roughsim.surface.topography.netcdf import of_netcdf
from roughsim.surface.topography.periodic import periodic_part
from roughsim.surface.topography.profiles import line_modes, of_surface
from roughsim.surface.topography.sizes import assumed, taken, with_size_and_unit
from roughsim.surface.topography.text import (
    decoded,
    heights_of,
    refuse_damaged,
    table_of,
    without_coordinates,
)
from roughsim.surface.topography.texture import Texture, texture_of
from roughsim.surface.topography.undefined import filled, without_marks
from roughsim.untrusted import ChildEndedError, call_in_child, check_measured_file, unpacked

_MOST_UNDEFINED = 0.05  # share of points that are filled unasked
_MOST_FILLED = 0.5  # share of points that are filled on request
# of computing to read a file of so many bytes, packed
_LEAST_SECONDS = 10.0
_BYTES_PER_SECOND = 1e6
_NUMPY = b"\x93NUMPY"


class Topography(NamedTuple):
    """A measured map, detrended."""

    heights: Array  # m, shape `grid.shape`, without mean and, if not periodic, without tilt
    grid: Grid  # its points and lengths
    periodic: bool  # whether it goes on at its edges; else its spectrum is taken under a window
    reliable: float = np.inf  # wavenumber up to which the instrument resolves, rad/m
    undefined: float = 0.0  # share of points that were filled, weighted as in C(q)
    taken: str = ""  # what was read of the file, in words

    @property
    def bins(self) -> BinnedSpectrum:
        """C(q), averaged over directions and bins of log q."""
        return map_spectrum(self.heights, self.grid, periodic=self.periodic, reliable=self.reliable)

    @property
    def directions(self) -> Directions:
        """M(q, φ) of C(q⃗) = C(q) M, from its periodic part."""
        heights = self.heights if self.periodic else periodic_part(self.heights)
        power = np.abs(np.fft.rfft2(heights)) ** 2
        return measured_directions(power, self.grid, min(self.grid.nyquist, self.reliable))

    @property
    def texture(self) -> Texture:
        """The lay of its slopes, and how far its heights are from Gaussian ones."""
        return texture_of(self.heights, self.grid, periodic=self.periodic, reliable=self.reliable)


class Profile(NamedTuple):
    """A measured line scan, detrended: see `bins_of_lines`."""

    heights: Array  # m, at even steps
    length: float  # m
    periodic: bool
    reliable: float = np.inf
    undefined: float = 0.0
    taken: str = ""


def bins_of_lines(lines: Sequence[Profile]) -> list[BinnedSpectrum]:
    """Return C(q) of line scans of one surface that is alike in all directions: one for all that have the same modes.

    The mean over lines is taken of C₁, before it becomes C(q), as that needs waves whose C₁ is known.
    """
    groups = defaultdict[tuple[int, float], list[tuple[Array, Array, float]]](list)
    for line in lines:
        k, along, together = line_modes(
            line.heights, line.length, periodic=line.periodic, reliable=line.reliable
        )
        groups[k.size, float(k[0])].append((k, along, together))
    bins = []
    for group in groups.values():
        k, _, together = group[0]
        mean = np.mean([along for _, along, _ in group], axis=0)
        bins.append(of_surface(k, mean, together=together, lines=len(group)))
    return bins


def read_scan(
    path: str | Path,
    *,
    size: Sequence[float] | None = None,
    unit: float | None = None,
    fill: str | None = None,
    channel: str | int | None = None,
    cut: float = np.inf,
) -> Topography | Profile:
    """Read a map of heights or a line scan, fill undefined points, and subtract mean and tilt.

    The content decides, not the name. Text of numbers, .npy and netCDF with coordinates are read by roughsim: see
    `roughsim.surface.topography.text.heights_of` for the order of the numbers. Any other format, and text whose header
    has a size or a unit, is read by SurfaceTopography (x3p, sur, gwy, opd, al3d, …). A file packed by gzip is unpacked.
    Of several channels of heights the file's default is taken, with a RuntimeWarning that names all. A scan is periodic
    only if the file marks it so. A RuntimeWarning names the points left out or filled.

    Parameters
    ----------
    path : str or Path
        The file.
    size : (float, float), optional
        Side lengths along x and y, m, of a file without sizes; of a line scan both are its length.
    unit : float, optional
        Unit of the heights, m, of a file without a unit; with a RuntimeWarning also of coordinates without a unit, if
        `size` is None.
    fill : {"smooth"}, optional
        "smooth": undefined points are filled by harmonic interpolation, up to half of all. None: only up to 5 %.
    channel : str or int, optional
        Name of a channel of heights, or its number among them, from 1 on.
    cut : float
        Wavenumber up to which C(q) is used, rad/m.

    Raises
    ------
    ImportError
        Without SurfaceTopography, if the file needs it.
    FileNotFoundError
        Without the file.
    RecordError
        Of one line, if the file is refused (see `roughsim.untrusted`), cannot be read, or holds no such heights.
    """
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(f"{path} does not exist; check the path")
    try:
        with unpacked(path) as file:
            check_measured_file(file, path)
            seconds = _LEAST_SECONDS + path.stat().st_size / _BYTES_PER_SECOND
            found: Contents = call_in_child(_contents_of, file, channel, seconds=seconds)
        scan, notes = _scan_of(path, with_size_and_unit(found, size, unit), fill)
        scan = scan._replace(reliable=min(scan.reliable, cut), taken=taken(found, size, unit))
        shortest = scan.length if isinstance(scan, Profile) else min(scan.grid.lengths)
        if 2 * np.pi / shortest > cut:
            raise NoHeightsError(
                f"has waves up to {shortest:.4g} m alone, all cut by topography_cut = {cut:.6g} rad/m"
            )
    except (RecordError, ImportError):
        raise
    except NoHeightsError as error:
        raise RecordError(f"{path} {error}") from None
    except ChildEndedError as error:
        raise RecordError(f"{path} cannot be read: {error}; it is damaged, or crop it") from error
    except Exception as error:
        raise RecordError(f"{path} {_unreadable(error)}") from error
    if size is not None and isinstance(scan, Topography):
        nx, ny = scan.grid.shape
        x, y = scan.grid.lengths
        oblong = abs(np.log(x * ny / (y * nx)))
        exchanged = abs(np.log(y * ny / (x * nx)))
        if oblong > 0.05 and exchanged < 0.01:
            notes.append(
                "with the two sides of topography_size exchanged its pixels would be square; the first side is along "
                "x, from line to line of a text"
            )
    for note in [*notes, *assumed(found, channel, size, unit)]:
        warnings.warn(f"{path}: {note}", RuntimeWarning, stacklevel=2)
    return scan


def _contents_of(file: Path, channel: str | int | None) -> Contents:
    """Return the heights of a file that was checked; NoHeightsError of one line otherwise. Runs in the child."""
    try:
        found = _of_format(file, channel)
    except (NoHeightsError, ImportError):
        raise
    except Exception as error:  # readers of binary formats, each with its own failures
        raise NoHeightsError(_unreadable(error)) from None
    if channel is not None and not found.channels:
        raise NoHeightsError("has no channels to choose from; remove topography_channel")
    return found


def _unreadable(error: Exception) -> str:
    """Return why a file cannot be read, after its name."""
    reason = " ".join(str(error).split())[:100]
    return f"cannot be read as heights ({type(error).__name__}: {reason}); it is damaged or of another format"


def _of_format(file: Path, channel: str | int | None) -> Contents:
    """Return the heights of a file by the reader of its format."""
    with open(file, "rb") as stream:
        start = stream.read(4096)
        if (reason := no_map(start)) is not None:
            raise NoHeightsError(reason)
        if start.startswith(_NUMPY):
            numbers = np.load(file, mmap_mode="r", allow_pickle=False)
            if numbers.dtype.kind not in "uif":
                raise NoHeightsError(
                    f"holds an array of dtype {numbers.dtype}; heights must be real numbers"
                )
            check_points(numbers.shape)
            heights = np.array(numbers, dtype=float)
            return without_coordinates(heights) if heights.ndim == 2 else Contents(heights)
        if (found := of_netcdf(file, start, channel)) is not None:
            return found
        text = decoded(start) and decoded(file.read_bytes())
        if text is not None:
            return _of_text(text)
        stream.seek(0)
        found = of_instrument(stream, channel=channel)
        if found is None and start.startswith(TIFF):
            found = of_tiff(file, channel)
    if found is None:
        raise NoHeightsError(unknown(file, start))
    return found


def _of_text(text: str) -> Contents:
    """Return the heights of a text: by SurfaceTopography if a line has size, unit or points, else its numbers."""
    if not text.strip():
        raise NoHeightsError("is empty; is it the right file?")
    try:
        table = table_of(text)
        bare = not any(sign in line for line in table.header for sign in "=:;,\t0123456789")
    except NoHeightsError:
        library()
        table = None
        bare = False
    if not bare:
        refuse_damaged(table.header if table is not None else text.splitlines())
        if table is not None and table.layout.comma:
            text = text.replace(",", ".")
        found = of_instrument(BytesIO(text.encode()), text=True)
        if found is not None:
            return found
    return heights_of(table if table is not None else table_of(text))


def _scan_of(
    path: Path, found: Contents, fill: str | None
) -> tuple[Topography | Profile, list[str]]:
    """Return the scan of contents in m, filled and levelled, and notes on points left out or filled."""
    heights, marks = without_marks(found.heights)
    left_out = [
        *found.left_out,
        *(f"heights of {mark:g}, which stand for undefined points" for mark in marks),
    ]
    notes = [f"left out: {' and '.join(left_out)}"] if left_out else []
    check_points(heights.shape)
    sizes = tuple(float(size) for size in found.sizes or ())
    if not all(0.0 < size < np.inf for size in sizes):
        some = " and ".join(f"{size:.4g} m" for size in sizes)
        raise NoHeightsError(f"has sizes of {some}; they must be above 0")
    undefined = np.isnan(heights)
    share = float(np.mean(undefined))
    most = _MOST_UNDEFINED if fill is None else _MOST_FILLED
    if share > most:
        advice = 'write topography_fill = "smooth" to fill them, or ' * (
            fill is None and share <= _MOST_FILLED
        )
        raise RecordError(
            f"{path}: {100 * share:.3g} % of its points are undefined, above {100 * most:g} %; {advice}crop it"
        )
    if share:
        notes.append(f"undefined points, {100 * share:.2g} %, were filled")
        heights = filled(heights, undefined)
    heights = float(found.unit or 0.0) * heights
    if not np.ptp(heights) > 0.0:
        raise NoHeightsError("holds heights that are all alike; there is no C(q) to measure")
    heights = levelled(heights, found.periodic)
    if heights.ndim == 1:
        return Profile(heights, sizes[0], found.periodic, found.reliable, share), notes
    grid = Grid((heights.shape[0], heights.shape[1]), (sizes[0], sizes[1]))
    weighted = share if found.periodic or not share else window_share(undefined, grid)
    return Topography(heights, grid, found.periodic, found.reliable, weighted), notes
