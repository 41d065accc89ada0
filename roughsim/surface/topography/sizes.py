"""Sizes and units of a scan: of its file, or else of the keys; and what was taken, in words."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from roughsim.surface.topography.contents import Contents, NoHeightsError, numbered, unit_name


def with_size_and_unit(
    found: Contents, size: Sequence[float] | None, unit: float | None
) -> Contents:
    """Return contents in m, by the units of the file or else by the arguments."""
    differs = found.unit is not None and (unit is None or abs(unit / found.unit - 1.0) > 1e-9)
    own = _keys(size=found.sizes is not None and found.lateral_unit is not None, unit=differs)
    # sides without a unit have the unit of the heights, unless only the file states that
    unknown_size = found.sizes is None or (found.lateral_unit is None and found.unit is not None)
    needed = _keys(size=unknown_size, unit=found.unit is None)
    given = _keys(size=size is not None, unit=unit is not None)
    if excess := sorted(given & own):
        raise NoHeightsError(
            f"contains its {_without_prefix(excess)}; remove {' and '.join(excess)}"
        )
    if lacking := sorted(needed - given):
        keys = " and ".join(lacking)
        raise NoHeightsError(
            f"lacks its {_without_prefix(lacking)}; give {keys}, or save it as x3p or nc"
        )
    unit_of_heights = found.unit if found.unit is not None else float(unit or 0.0)
    return replace(
        found, sizes=_sizes(found, size, unit_of_heights), unit=unit_of_heights, lateral_unit=1.0
    )


def _keys(*, size: bool, unit: bool) -> set[str]:
    """Return the keys of a scan that a condition concerns."""
    return {
        key
        for key, concerned in (("topography_size", size), ("topography_unit", unit))
        if concerned
    }


def _without_prefix(keys: list[str]) -> str:
    return " and ".join(key.removeprefix("topography_") for key in keys)


def _sizes(
    found: Contents, size: Sequence[float] | None, unit_of_heights: float
) -> tuple[float, ...]:
    """Return the sides of a map or the length of a line scan, m: of the file, or else the given ones."""
    if found.sizes is not None and (found.lateral_unit is not None or size is None):
        factor = found.lateral_unit if found.lateral_unit is not None else unit_of_heights
        return tuple(factor * length for length in found.sizes)
    given = tuple(size or ())
    if found.heights.ndim == 1 and len(set(given)) > 1:
        raise NoHeightsError(
            "holds a line scan, which has one length; write one length as topography_size"
        )
    return given[: found.heights.ndim]


def taken(found: Contents, size: Sequence[float] | None, unit: float | None) -> str:
    """Return the units and the channel that were read, in words."""
    heights = f"heights in {unit_name(found.unit or unit or 1.0)}" + " by topography_unit" * (
        found.unit is None
    )
    if found.lateral_unit is not None:
        sides = f"sides in {unit_name(found.lateral_unit)}"
    else:
        sides = (
            "sides by topography_size" if size is not None else "sides in the unit of the heights"
        )
    name = (
        "Default" if found.channel is None else found.channels[found.channel]
    )  # of files with one, by their reader
    channel = "" if name == "Default" else f"channel {name[:40]!r}, "
    return f"{channel}{heights}, {sides}"


def assumed(
    found: Contents, channel: str | int | None, size: Sequence[float] | None, unit: float | None
) -> Iterator[str]:
    """Yield what neither the file nor a key states: the channel of several, and the unit of coordinates."""
    if channel is None and found.channel is not None and len(found.channels) > 1:
        yield (
            f"the channel {found.channels[found.channel][:30]!r} is taken; topography_channel chooses another one: "
            f"{numbered(found.channels)}"
        )
    if found.sizes is not None and found.lateral_unit is None and size is None:
        yield (
            f"coordinates have no unit, and are taken in {unit_name(unit or 1.0)} as the heights; if it is another "
            "one, write it into the heading (x/mm), or give topography_size"
        )
