"""Scans named in a scene: their sizes and units, and the C(q) that replaces them."""

import math
import re
import warnings
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from roughsim.scene.schema import Quantity, SceneError, as_written, did_you_mean
from roughsim.scene.tables import read_psd
from roughsim.show.text import plain

if TYPE_CHECKING:
    from roughsim.grid import Grid
    from roughsim.surface.topography import Profile, Topography

_MOST_SCANS = 32  # of one face: their table with its errors still fits into a scene
_UNEVEN = 0.05  # of the larger number of points: more would make pixels of one length oblong
_MAP_SIZE = Quantity("m", '"1 mm"', gt=0)
_CUT = Quantity("rad/m", '"2.5e6 1/m"', gt=0)
MEASURED_KEYS = (
    "psd_source",
    "psd_error",
    "psd_scans",
    "psd_texture",
    "psd_filled",
)  # of C(q) measured on scans
# they go with `topography`
SCAN_KEYS = (
    "topography_size",
    "topography_unit",
    "topography_channel",
    "topography_cut",
    "topography_fill",
)


def measured_psd(
    paths: list[Path],
    section: dict[str, Any],
    found: "list[tuple[Path, Topography | Profile]] | None" = None,
) -> dict[str, Any]:
    """Measure C(q) of the scans of one surface; return the keys that give it, its error, and each map's texture.

    The scans are added to `found`, if it is given.
    """
    from roughsim.surface.topography import Topography, bins_of_lines, combined

    if len(paths) > _MOST_SCANS:
        raise SceneError(f"{len(paths)} scans are more than {_MOST_SCANS}; leave some out")
    bins, lines, textures, undefined, taken = [], [], [], [], []
    for path, scan in zip(paths, read_scans(paths, section), strict=True):
        taken.append(plain(f"{path.name[-60:]}: {scan.taken[:120]}"))
        if isinstance(scan, Topography):
            bins.append(scan.bins)
            textures.append([float(f"{number:.4g}") for number in scan.texture])
        else:
            lines.append(scan)
        undefined.append(scan.undefined)
        if found is not None:
            found.append((path, scan))
    spectrum, errors = combined(bins + bins_of_lines(lines))
    rows = [[float(q), float(psd)] for q, psd in zip(spectrum.q, spectrum.psd, strict=True)]
    rounded = [[float(f"{error:.3g}") for error in row] for row in errors.tolist()]
    known: dict[str, Any] = {"psd_source": "scan", "psd_error": rounded, "psd_scans": taken}
    if textures:
        known["psd_texture"] = textures
    if any(undefined):
        known["psd_filled"] = float(f"{max(undefined):.3g}")
    return {"psd": rows, "psd_convention": "persson"} | known


def psd_of_profile(name: str, section: Mapping[str, Any]) -> dict[str, Any]:
    """Return the section of a face with C(q), and the error of this, in place of the spectrum C₁ of a profile."""
    from roughsim.surface.topography.profiles import of_profile_table

    try:
        q, along = np.array(read_psd(section["psd"])).T
        psd, error = of_profile_table(q, along)
    except ValueError as fault:
        raise SceneError(f"{name}.psd{fault}") from None
    rows = [
        [float(wavenumber), float(f"{value:.6g}")] for wavenumber, value in zip(q, psd, strict=True)
    ]
    result = {**section, "psd": rows, "psd_convention": "persson"}
    if "psd_source" in section:  # the error of the scan itself is unknown
        return result
    return result | {"psd_source": "scan", "psd_error": [[float(f"{one:.3g}")] for one in error]}


def read_scans(paths: list[Path], section: Mapping[str, Any]) -> "Iterator[Topography | Profile]":
    """Yield the scans of one surface, with the size and the unit of a section if a file lacks them."""
    from roughsim.surface.topography import FILLS, Topography, read_scan

    nothing: list[tuple[float, float] | None] = [None] * len(paths)
    lengths = (
        _sizes(section["topography_size"], len(paths)) if "topography_size" in section else nothing
    )
    unit = _length_unit(section["topography_unit"]) if "topography_unit" in section else None
    cut = _cut(section["topography_cut"]) if "topography_cut" in section else math.inf
    channel = section.get("topography_channel")
    if isinstance(channel, bool) or not isinstance(channel, (str, int, type(None))):
        raise SceneError(
            f"topography_channel = {as_written(channel)} must be a name, or a number from 1 on"
        )
    fill = section.get("topography_fill")
    if fill is not None and fill not in FILLS:
        raise SceneError(
            f"topography_fill = {as_written(fill)} is not known; {did_you_mean(str(fill), FILLS)}"
        )
    for path, size in zip(paths, lengths, strict=True):  # one scan at a time in memory
        scan = read_scan(path, size=size, unit=unit, fill=fill, channel=channel, cut=cut)
        if not isinstance(section.get("topography_size", []), (list, tuple)) and isinstance(
            scan, Topography
        ):
            _warn_of_one_length(path, scan.grid)
        yield scan


def _warn_of_one_length(path: Path, grid: "Grid") -> None:
    """Warn of a map with one length for both sides, whose pixels then are oblong."""
    (nx, ny), (dx, dy) = grid.shape, grid.spacing
    if abs(nx - ny) > _UNEVEN * max(nx, ny):
        warnings.warn(
            f"{path}: one topography_size for {nx} × {ny} points makes pixels of {1e6 * dx:.3g} × {1e6 * dy:.3g} µm; "
            "write both sides, [x, y]",
            RuntimeWarning,
            stacklevel=2,
        )


def _sizes(value: Any, count: int) -> list[tuple[float, float] | None]:
    """Return the side lengths of each map, m, from one number, from two along x and y, or from pairs of them."""
    several = isinstance(value, (list, tuple)) and any(
        isinstance(entry, (list, tuple)) for entry in value
    )
    each = list(value) if several else [value] * count
    if len(each) != count:
        raise SceneError(
            f"topography_size has {len(each)} pairs for {count} files; give one for each, in their order"
        )
    pairs: list[tuple[float, float] | None] = []
    for k, size in enumerate(each):
        where = f"topography_size[{k}]" if several else "topography_size"
        pair = list(size) if isinstance(size, (list, tuple)) else [size, size]
        if len(pair) != 2:
            raise SceneError(
                f"{where} = {as_written(size)} must be one length, or two along x and y"
            )
        pairs.append((float(_MAP_SIZE(pair[0], where)), float(_MAP_SIZE(pair[1], where))))
    return pairs


def _cut(value: Any) -> float:
    """Return the wavenumber up to which C(q) is used, rad/m, from a wavenumber or a wavelength with its unit."""
    try:
        return float(_CUT(value, "topography_cut"))
    except ValueError:
        with suppress(ValueError):
            return (
                2
                * math.pi
                / float(_MAP_SIZE(value if isinstance(value, str) else "", "topography_cut"))
            )
        raise


def _length_unit(value: Any) -> float:
    """Return a unit of length, m."""
    if not isinstance(value, str) or re.match(r"\s*[-+.0-9]", value):
        raise SceneError(
            f'topography_unit = {as_written(value)} must be a unit of length, for example "um"'
        )
    return float(_MAP_SIZE(f"1 {value}", "topography_unit"))
