"""Formats of instruments through SurfaceTopography, and a sentence for a file that is none of them."""

import re
import warnings
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.surface.topography.contents import Contents, NoHeightsError

PICTURES = {b"\x89PNG": "PNG", b"\xff\xd8\xff": "JPEG", b"GIF8": "GIF", b"II*\x00": "TIFF", b"MM\x00*": "TIFF"}
_PACKED = {b"BZh": "bzip2", b"\xfd7zXZ": "xz", b"7z\xbc\xaf": "7z", b"Rar!": "rar", b"\x28\xb5\x2f\xfd": "zstd"}
_TIFF = (b"II*\x00", b"MM\x00*")  # some instruments write heights into one
_DOCUMENTS = re.compile(rb"\s*(%PDF|<!doctype html|<html)", re.IGNORECASE)
_ANYTHING = ("hgt",)  # a reader that takes any file of the right size
_PLAIN = ("asc", "xyz")  # readers of text, which take any numbers


def library() -> Any:
    """Return SurfaceTopography; ImportError with the command to install it."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ImportWarning)  # warns that there is no MPI
            import SurfaceTopography  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ImportError:
        raise ImportError("SurfaceTopography is not installed; type: pip install 'roughsim[topography]'") from None
    return SurfaceTopography


def of_instrument(stream: Any, check: Callable[[tuple[int, ...]], None], *, text: bool = False) -> Contents | None:
    """Return the heights of an open file as SurfaceTopography reads them.

    None if no reader takes it; with `text` also if no line of it has a size, a unit or a number of points. `check`
    refuses a shape before its heights are read.
    """
    try:
        reader = library().open_topography(stream)
        first, height_channels = reader.default_channel, reader.height_channels
    except ImportError:
        raise
    except Exception:  # forty readers of binary formats, each with its own failures
        return None
    if reader.format() in _ANYTHING:
        return None
    has_header = first.unit or first.info.get("raw_metadata")
    if text and reader.format() in _PLAIN and not has_header:
        return None
    channel = _channel_of_heights(first, height_channels)
    check(tuple(channel.nb_grid_pts) if channel.dim == 2 else (channel.nb_grid_pts[0],))
    if not channel.is_uniform:
        raise NoHeightsError("holds a line scan at uneven steps; put its heights on even steps first")
    return _contents_of(channel)


def _channel_of_heights(first: Any, height_channels: Sequence[Any]) -> Any:
    """Return the default channel of a file, `first`, or else its first one of heights; NoHeightsError if ambiguous."""
    channel = first
    if not first.is_height_channel:
        if not height_channels:
            raise NoHeightsError(f"holds no heights, but {first.data_kind.value}; save the heights")
        channel = height_channels[0]
    alike = [other.name for other in height_channels if other.dim == channel.dim]
    if channel.unit is None and len(alike) > 1:
        names = ", ".join(str(name) for name in alike)[:80]
        raise NoHeightsError(f"holds several sets of numbers without a unit, {names}; save the heights alone")
    return channel


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
    return Contents(np.ascontiguousarray(heights), sizes, unit, unit, bool(found.is_periodic), reliable)


def no_map(start: bytes) -> str | None:
    """Return the kind of a file that begins with `start` and surely holds no heights, and the remedy; else None."""
    if start.startswith(b"version https://git-lfs"):
        return "is a pointer of Git LFS in place of the file; fetch the file itself: git lfs pull"
    for magic, kind in PICTURES.items():
        if start.startswith(magic) and magic not in _TIFF:
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
    if start.startswith(_TIFF):
        return "is a picture (TIFF); heights need the file of the instrument"
    from SurfaceTopography import IO

    for reader in IO.readers:
        if reader.can_read(start[:512]) == IO.MagicMatch.YES:
            return f"begins as {reader.name()}, but is cut short or damaged; save or copy it again"
    return "has no format that is known; save it as x3p or nc"


def _about_container(path: Path) -> str:
    """Return the number and the first names of the scans in a zip file, and the remedy."""
    with zipfile.ZipFile(path) as archive:
        names = [entry.filename for entry in archive.infolist() if not entry.is_dir()]
    descriptions = (".yml", ".yaml", ".json", ".md")  # in containers of scans
    scans = [name for name in names if Path(name).suffix.lower() not in descriptions]
    if not scans:
        return "is a container without a scan; name the file of the instrument"
    some = ", ".join(name[:40] for name in scans[:3]) + (" …" if len(scans) > 3 else "")
    count = "1 file" if len(scans) == 1 else f"{len(scans)} files"
    return f"is a container of {count}; unpack it and name its scans ({some})"
