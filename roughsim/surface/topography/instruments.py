"""Formats of instruments through SurfaceTopography, and a sentence for a file that is none of them."""

import re
import warnings
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.surface.topography.contents import (
    Contents,
    NoHeightsError,
    check_points,
    index_of_channel,
    numbered,
)

PICTURES = {b"\x89PNG": "PNG", b"\xff\xd8\xff": "JPEG", b"GIF8": "GIF"}
_PACKED = {
    b"BZh": "bzip2",
    b"\xfd7zXZ": "xz",
    b"7z\xbc\xaf": "7z",
    b"Rar!": "rar",
    b"\x28\xb5\x2f\xfd": "zstd",
}
_GWY = b"GWYP"
_GWY_TITLE = re.compile(rb"/\d+/data/title\x00s([^\x00]*)\x00")  # of a channel
_GWY_AMPERE = "'si_unit_z': {'GwySIUnit': {'unitstr': 'A'}}"
_HDF5 = b"\x89HDF\r\n\x1a\n"
TIFF = (b"II*\x00", b"MM\x00*", b"II+\x00", b"MM\x00+")  # some instruments write heights into one
_DOCUMENTS = re.compile(rb"\s*(%PDF|<!doctype html|<html)", re.IGNORECASE)
_ANYTHING = ("hgt",)  # a reader that takes any file of the right size
_PLAIN = ("asc", "xyz")  # readers of text, which take any numbers


def library() -> Any:
    """Return SurfaceTopography; ImportError with the command to install it, or with the reason why it does not load."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ImportWarning)  # warns that there is no MPI
            import SurfaceTopography  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ModuleNotFoundError as error:
        missing = error.name or "SurfaceTopography"
        raise ImportError(
            f"{missing} is not installed; type: pip install 'roughsim[topography]'"
        ) from None
    except (
        Exception
    ) as error:  # of a library that it loads: without an MPI library, mpi4py raises a RuntimeError
        reason = " ".join(str(error).split())[:200]
        raise ImportError(
            f"SurfaceTopography, which reads this file, cannot be imported ({type(error).__name__}: {reason}); install "
            "what is missing, or remove mpi4py if there is no MPI library"
        ) from None
    return SurfaceTopography


def of_instrument(
    stream: Any, *, channel: str | int | None = None, text: bool = False
) -> Contents | None:
    """Return the heights of an open file as SurfaceTopography reads them, of a `channel` by its name or number.

    None if no reader takes it; with `text` also if no line of it has a size, a unit or a number of points.
    """
    try:
        reader = library().open_topography(stream)
        channels = [one for one in reader.channels if not _is_current(one)]
        first = reader.default_channel
    except ImportError:
        raise
    except Exception:  # forty readers of binary formats, each with its own failures
        return None
    if not channels or reader.format() in _ANYTHING:
        return None
    has_header = first.unit or first.info.get("raw_metadata")
    if text and reader.format() in _PLAIN and not has_header:
        return None
    heights = [one for one in channels if one.is_height_channel]
    if not heights:
        kinds = [
            f"{str(one.name)[:30]!r} in {one.data_unit or one.data_kind.value}" for one in channels
        ]
        raise NoHeightsError(
            f"holds no channel of heights, only {_first(kinds, 6)}; save the heights"
        )
    names = tuple(str(one.name) for one in heights)
    index = _default_index(first, heights) if channel is None else index_of_channel(names, channel)
    found = heights[index]
    check_points(tuple(found.nb_grid_pts[: found.dim]))
    if not found.is_uniform:
        raise NoHeightsError(
            "holds a line scan at uneven steps; put its heights on even steps first"
        )
    return _contents_of(found)._replace(channel=index, channels=names)


def of_tiff(path: Path, channel: str | int | None) -> Contents | None:
    """Return the heights of a TIFF of floating-point numbers, x along a line; None without such a page.

    `channel` is the number of a page, or its name "page 1".
    """
    import tifffile

    try:
        with tifffile.TiffFile(path) as file:
            planes = [page for page in file.pages if page.ndim == 2]
            pages = [page for page in planes if page.dtype is not None and page.dtype.kind == "f"]
            if not pages:
                return None
            names = tuple(f"page {number}" for number in range(1, len(pages) + 1))
            index = 0 if channel is None else index_of_channel(names, channel)
            check_points(pages[index].shape[::-1])
            heights = np.array(pages[index].asarray(), dtype=float).T
    except tifffile.TiffFileError:
        return None
    return Contents(np.ascontiguousarray(heights), channel=index, channels=names)


def _default_index(first: Any, heights: Sequence[Any]) -> int:
    """Return the index of the default channel of a file, `first`, or else 0; NoHeightsError if ambiguous."""
    index = next((i for i, one in enumerate(heights) if one.index == first.index), 0)
    alike = [str(other.name) for other in heights if other.dim == heights[index].dim]
    if heights[index].unit is None and len(alike) > 1:
        raise NoHeightsError(
            f"holds several sets of numbers without a unit, {numbered(alike)}; write the name of one as "
            "topography_channel, or save the heights alone"
        )
    return index


def _is_current(channel: Any) -> bool:
    """Whether the unit of a channel of Gwyddion is the ampere, which SurfaceTopography reads as the ångström."""
    metadata = channel.info.get("raw_metadata") or {}
    fields = [value for key, value in metadata.items() if re.fullmatch(r"/\d+/data", str(key))]
    return any(_GWY_AMPERE in str(field) for field in fields)


def _first(texts: Sequence[str], most: int) -> str:
    """Return the first texts of several."""
    return ", ".join(texts[:most]) + " …" * (len(texts) > most)


def _contents_of(channel: Any) -> Contents:
    """Return the heights of a channel, with their sizes, unit and cut-off wavenumber as far as the file has them."""
    has_sizes = channel.physical_sizes is not None
    found = channel.topography(**({} if has_sizes else {"physical_sizes": (1.0,) * channel.dim}))
    unit = None
    reliable = np.inf
    if channel.unit is not None:
        in_metres = found.to_unit("m")
        unit = float(in_metres.physical_sizes[0]) / float(found.physical_sizes[0])
        cutoff = in_metres.short_reliability_cutoff() if has_sizes else None
        if cutoff is not None:
            reliable = 2 * np.pi / float(cutoff)
    heights = np.ma.filled(np.ma.asarray(found.heights(), dtype=np.float64), np.nan)
    sizes = tuple(float(size) for size in found.physical_sizes) if has_sizes else None
    return Contents(
        np.ascontiguousarray(heights), sizes, unit, unit, bool(found.is_periodic), reliable
    )


def no_map(start: bytes) -> str | None:
    """Return the kind of a file that begins with `start` and surely holds no heights, and the remedy; else None."""
    if start.startswith(b"version https://git-lfs"):
        return "is a pointer of Git LFS in place of the file; fetch the file itself: git lfs pull"
    for magic, kind in PICTURES.items():
        if start.startswith(magic):
            return f"is a picture ({kind}); heights need the file of the instrument"
    for magic, kind in _PACKED.items():
        if start.startswith(magic):
            return f"is packed ({kind}); unpack it and name its scan"
    if start[257:262] == b"ustar":
        return "is packed (tar); unpack it and name its scan"
    if _DOCUMENTS.match(start):
        return "is a document or a page of the web; heights need the file of the instrument"
    return None


def unknown(path: Path, start: bytes) -> str:
    """Return why no reader takes a file that begins with `start`, and the remedy."""
    if start.startswith(b"PK"):
        return _about_container(path)
    if start.startswith(TIFF):
        return "is a picture (TIFF) without floating-point numbers; heights need the file of the instrument"
    if start.startswith(_HDF5):
        return _about_hdf5(path)
    if start.startswith(_GWY) and (titles := _GWY_TITLE.findall(path.read_bytes())):
        some = ", ".join(repr(title[:30].decode(errors="replace")) for title in titles[:6])
        return f"holds no channel of heights, only {some}; save the heights"
    from SurfaceTopography import IO

    for reader in IO.readers:
        if reader.can_read(start[:512]) == IO.MagicMatch.YES:
            return f"begins as {reader.name()}, but is cut short or damaged; save or copy it again"
    return "has no format that is known; save it as x3p or nc"


def _about_hdf5(path: Path) -> str:
    """Return the names and the shapes of the first datasets of an HDF5 file that has no map, and the remedy."""
    import h5py

    found = []

    def visit(name: str, one: Any) -> None:
        if hasattr(one, "shape"):
            found.append(f"{name[:40]} of shape {one.shape}")

    with h5py.File(path, "r", locking=False) as file:
        file.visititems(visit)
    some = f"but {_first(found, 3)}" if found else "and no dataset"
    return f"holds no map, {some}; save a map of two dimensions"


def _about_container(path: Path) -> str:
    """Return the number and the first names of the scans in a zip file, and the remedy."""
    with zipfile.ZipFile(path) as archive:
        names = [entry.filename for entry in archive.infolist() if not entry.is_dir()]
    descriptions = (".yml", ".yaml", ".json", ".md")  # in containers of scans
    scans = [name for name in names if Path(name).suffix.lower() not in descriptions]
    if not scans:
        return "is a container without a scan; name the file of the instrument"
    some = _first([name[:40] for name in scans], 3)
    count = "1 file" if len(scans) == 1 else f"{len(scans)} files"
    return f"is a container of {count}; unpack it and name its scans ({some})"
