"""Maps of heights that a scene names: their sizes and units, and the C(q) that stands in their place."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughsim.scene.schema import Quantity, SceneError, as_written

if TYPE_CHECKING:
    from roughsim.surface.topography import Topography

MOST_SCANS = 32  # of one face: their table with its errors still fits into a scene
MAP_SIZE = Quantity("m", '"1 mm"', above=0)
PLAIN_KEYS = ("topography_size", "topography_unit")  # of .txt, .csv and .npy


def measured_psd(paths: list[Path], section: dict[str, Any]) -> dict[str, Any]:
    """Measure C(q) of the maps of one surface; return the keys that give it, its error, and each texture."""
    from roughsim.surface.topography import combined

    if len(paths) > MOST_SCANS:
        raise SceneError(f"{len(paths)} scans are more than {MOST_SCANS}; leave some out")
    bins, textures = zip(*((found.bins, found.texture) for found in read_maps(paths, section)), strict=True)
    spectrum, errors = combined(bins)
    rows = [[float(q), float(psd)] for q, psd in zip(spectrum.q, spectrum.psd, strict=True)]
    rounded_textures = [[float(f"{number:.4g}") for number in texture] for texture in textures]
    rounded = [[float(f"{error:.3g}") for error in row] for row in errors.tolist()]
    known = {"psd_source": "scan", "psd_error": rounded, "psd_texture": rounded_textures}
    return {"psd": rows, "psd_convention": "persson"} | known


def read_maps(paths: list[Path], section: Mapping[str, Any]) -> "Iterator[Topography]":
    """Yield the maps of one surface, with the size and the unit that a section gives for plain numbers."""
    from roughsim.surface.topography import is_plain, read_topography

    plain = [is_plain(path) for path in paths]
    given = [key for key in PLAIN_KEYS if key in section]
    if given and not any(plain):
        raise SceneError(f"{' and '.join(given)} go with .txt, .csv and .npy, as these files say it; remove them")
    nothing: list[tuple[float, float] | None] = [None] * len(paths)
    lengths = sizes(section["topography_size"], len(paths)) if "topography_size" in section else nothing
    unit = length_unit(section["topography_unit"]) if "topography_unit" in section else None
    for path, bare, size in zip(paths, plain, lengths, strict=True):  # one map at a time in memory
        yield read_topography(path, size=size, unit=unit) if bare else read_topography(path)


def sizes(value: Any, count: int) -> list[tuple[float, float] | None]:
    """Return the side lengths of each map, m, from one number, from two along x and y, or from pairs of them."""
    several = isinstance(value, (list, tuple)) and any(isinstance(entry, (list, tuple)) for entry in value)
    each = list(value) if several else [value] * count
    if len(each) != count:
        raise SceneError(f"topography_size has {len(each)} pairs for {count} files; give one for each, in their order")
    pairs: list[tuple[float, float] | None] = []
    for k, size in enumerate(each):
        where = f"topography_size[{k}]" if several else "topography_size"
        pair = list(size) if isinstance(size, (list, tuple)) else [size, size]
        if len(pair) != 2:
            raise SceneError(f"{where} = {as_written(size)} must be one length, or two along x and y")
        pairs.append((float(MAP_SIZE(pair[0], where)), float(MAP_SIZE(pair[1], where))))
    return pairs


def length_unit(value: Any) -> float:
    """Return a unit of length, m."""
    if not isinstance(value, str) or re.match(r"\s*[-+.0-9]", value):
        raise SceneError(f'topography_unit = {as_written(value)} must be a unit of length, for example "um"')
    return float(MAP_SIZE(f"1 {value}", "topography_unit"))
