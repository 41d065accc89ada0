"""Scans named in a scene: how they are read, and the C(q) that replaces them."""

import math
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator

from roughsim.scene.schema import (
    Quantity,
    Record,
    SceneError,
    as_written,
    is_list,
    one_or_list,
    record,
)
from roughsim.scene.tables import read_psd
from roughsim.show.text import plain

if TYPE_CHECKING:
    from roughsim.grid import Grid
    from roughsim.surface.topography.reading import Profile, Topography

_MOST_SCANS = 32  # of one face: their table with its errors still fits into a scene
_UNEVEN = 0.05  # of the larger number of points: more would make pixels of one length oblong
_LENGTH = Quantity("m", '"1 mm"', gt=0)
_ANGLE = Quantity("rad", '"90 deg"', ge=-2 * math.pi, le=2 * math.pi)
_CUT = Quantity("rad/m", '"2.5e6 1/m"', gt=0)
MEASURED_KEYS = (
    "psd_source",
    "psd_error",
    "psd_scans",
    "psd_texture",
    "psd_filled",
)  # of C(q) measured on scans


def _each_size(value: Any) -> Any:
    """Return a list of sizes, one of all scans or one of each."""
    return value if is_list(value) and any(map(is_list, value)) else [value]


def _read_unit(value: Any) -> Any:
    """Return a unit of length, m."""
    if not isinstance(value, str) or re.match(r"\s*[-+.0-9]", value):
        raise ValueError(f' = {as_written(value)} must be a unit of length, for example "um"')
    return _LENGTH(f"1 {value}")


def _read_channel(value: Any) -> Any:
    """Return the name or the number of a channel."""
    if isinstance(value, bool) or not isinstance(value, (str, int)):
        raise ValueError(f" = {as_written(value)} must be a name, or a number from 1 on")
    return value


def _read_cut(value: Any) -> Any:
    """Return a wavenumber, rad/m, of a wavenumber or a wavelength with its unit."""
    try:
        return _CUT(value)
    except ValueError:
        if isinstance(value, str):
            with suppress(ValueError):
                return 2 * math.pi / _LENGTH(value)
        raise


@record()
class ScanOptions(Record):
    """The keys beside `topography`, which describe its files."""

    topography_size: (
        Annotated[
            tuple[
                Annotated[
                    tuple[Annotated[float, _LENGTH], Annotated[float, _LENGTH]], one_or_list(2)
                ],
                ...,
            ],
            BeforeValidator(_each_size),
        ]
        | None
    ) = None
    """Sides along x and y of all maps, or of each."""
    topography_unit: Annotated[float, BeforeValidator(_read_unit)] | None = None
    """Of the heights, m."""
    topography_channel: Annotated[str | int, BeforeValidator(_read_channel)] | None = None
    topography_cut: Annotated[float, BeforeValidator(_read_cut)] = math.inf
    """Wavenumber up to which C(q) is used, rad/m."""
    topography_fill: Literal["smooth"] | None = None
    """Of undefined points."""
    topography_direction: Annotated[tuple[Annotated[float, _ANGLE], ...], one_or_list()] | None = (
        None
    )
    """Of each line scan, from x towards y: they give the lay."""


def measured_psd(
    paths: list[Path],
    section: dict[str, Any],
    found: "list[tuple[Path, Topography | Profile]] | None" = None,
) -> dict[str, Any]:
    """Measure C(q) of the scans of one surface; return the keys that give it, its error, and each map's texture.

    The scans are added to `found`, if it is given.
    """
    from roughsim.surface.topography.measured import combined
    from roughsim.surface.topography.reading import Topography, bins_of_lines

    if len(paths) > _MOST_SCANS:
        raise SceneError(f"{len(paths)} scans are more than {_MOST_SCANS}; leave some out")
    bins, lines, textures, undefined, taken = [], [], [], [], []
    for path, scan in zip(paths, read_scans(paths, section), strict=True):
        taken.append(plain(f"{path.name[-60:]}: {scan.taken[:120]}"))
        undefined.append(scan.undefined)
        if isinstance(scan, Topography):
            bins.append(scan.bins)
            textures.append(scan.texture)
        else:
            lines.append(scan)
        if found is not None:
            found.append((path, scan))
    lay: dict[str, float] = {}
    if section.get("topography_direction") is not None:
        if textures:
            raise SceneError("topography_direction is of line scans; a map has its own: remove it")
        lines, lay = _with_lay(lines, section)
    spectrum, errors = combined(bins + bins_of_lines(lines))
    directions = None
    if isinstance(scan, Topography) and len(paths) == 1:
        factor = scan.directions
        if not textures[0].isotropic or factor.crossed:
            directions = [[q, *row] for q, row in zip(factor.q, factor.rows, strict=True)]
    return {
        "psd": np.column_stack([spectrum.q, spectrum.psd]).tolist(),
        "psd_convention": "persson",
        "psd_source": "scan",
        "psd_error": _rounded(errors, 3),
        "psd_scans": taken,
        "psd_texture": _rounded(textures, 4) or None,
        "psd_directions": directions,
        "psd_filled": float(f"{max(undefined):.3g}") or None,
        **lay,
    }


def _with_lay(
    lines: "list[Profile]", section: Mapping[str, Any]
) -> "tuple[list[Profile], dict[str, float]]":
    """Return line scans of the isotropic surface that a lay stretches, and the keys of that lay, if there is one."""
    from roughsim.surface.topography.line_lay import Line, lay_of_lines, stretch
    from roughsim.surface.topography.texture import UNEVEN

    angles = _options(section).topography_direction or ()
    if len(angles) != len(lines):
        raise SceneError(
            f"topography_direction has {len(angles)} angles for {len(lines)} files; give one for each, in their order"
        )
    each = list(zip(lines, angles, strict=True))
    gamma, grooves = lay_of_lines([Line(one.heights, one.length, angle) for one, angle in each])
    if gamma <= UNEVEN:
        return lines, {}
    gamma = float(f"{gamma:.3g}")
    ratios = [stretch(gamma, angle - grooves) for angle in angles]
    stretched = [
        one._replace(length=one.length * ratio, reliable=one.reliable / ratio)
        for one, ratio in zip(lines, ratios, strict=True)
    ]
    return stretched, {"lay": gamma, "lay_direction": float(f"{grooves:.4g}")}


def _options(section: Mapping[str, Any]) -> ScanOptions:
    """Return the keys beside `topography` of a section."""
    keys = ScanOptions.known_keys()
    return ScanOptions(**{key: value for key, value in section.items() if key in keys})


def _rounded(rows: Iterable[Iterable[float]], digits: int) -> list[list[float]]:
    """Return numbers with so many significant digits."""
    return [[float(f"{number:.{digits}g}") for number in row] for row in rows]


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
    return result | {"psd_source": "scan", "psd_error": _rounded(error[:, None], 3)}


def read_scans(paths: list[Path], section: Mapping[str, Any]) -> "Iterator[Topography | Profile]":
    """Yield the scans of one surface, with the size and the unit of a section if a file lacks them."""
    from roughsim.surface.topography.reading import Topography, read_scan

    options = _options(section)
    sizes: tuple[tuple[float, float] | None, ...] = options.topography_size or (None,)
    if len(sizes) == 1:
        sizes = sizes * len(paths)
    if len(sizes) != len(paths):
        raise SceneError(
            f"topography_size has {len(sizes)} pairs for {len(paths)} files; give one for each, in their order"
        )
    for path, size in zip(paths, sizes, strict=True):  # one scan at a time in memory
        scan = read_scan(
            path,
            size=size,
            unit=options.topography_unit,
            fill=options.topography_fill,
            channel=options.topography_channel,
            cut=options.topography_cut,
        )
        one_length = not is_list(section.get("topography_size", []))
        if one_length and isinstance(scan, Topography):
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
