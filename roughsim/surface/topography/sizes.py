"""Sizes and units of a scan: of its file, or else of the keys; and what was taken, in words."""

from collections.abc import Iterator, Sequence

from roughsim.surface.topography.contents import Contents, NoHeightsError, numbered, unit_name


def with_size_and_unit(
    found: Contents, size: Sequence[float] | None, unit: float | None
) -> Contents:
    """Return contents in m, by the units of the file or else by the arguments."""
    has_sizes = found.sizes is not None and found.lateral_unit is not None
    differs = found.unit is not None and (unit is None or abs(unit / found.unit - 1.0) > 1e-9)
    # sides without a unit have the unit of the heights, unless only the file states that
    lacks_sizes = found.sizes is None or (found.lateral_unit is None and found.unit is not None)
    excess = {"size": size is not None and has_sizes, "unit": unit is not None and differs}
    lacking = {"size": size is None and lacks_sizes, "unit": unit is None and found.unit is None}
    if any(excess.values()):
        short, keys = _names(excess)
        raise NoHeightsError(f"contains its {short}; remove {keys}")
    if any(lacking.values()):
        short, keys = _names(lacking)
        raise NoHeightsError(f"lacks its {short}; give {keys}, or save it as x3p or nc")
    unit_of_heights = found.unit if found.unit is not None else float(unit or 0.0)
    sizes = tuple(size or ())
    if found.sizes is not None and (found.lateral_unit is not None or size is None):
        factor = found.lateral_unit if found.lateral_unit is not None else unit_of_heights
        sizes = tuple(factor * length for length in found.sizes)
    elif found.heights.ndim == 1 and len(set(sizes)) > 1:
        raise NoHeightsError(
            "holds a line scan, which has one length; write one length as topography_size"
        )
    sizes = sizes[: found.heights.ndim]
    return found._replace(sizes=sizes, unit=unit_of_heights, lateral_unit=1.0)


def _names(concerned: dict[str, bool]) -> tuple[str, str]:
    """Return the quantities that a condition concerns, and their keys in a scene."""
    names = [name for name, yes in concerned.items() if yes]
    return " and ".join(names), " and ".join(f"topography_{name}" for name in names)


def taken(found: Contents, size: Sequence[float] | None, unit: float | None) -> str:
    """Return the units and the channel that were read, in words."""
    heights = f"heights in {unit_name(found.unit or unit or 1.0)}"
    heights += " by topography_unit" * (found.unit is None)
    sides = "sides by topography_size" if size is not None else "sides in the unit of the heights"
    if found.lateral_unit is not None:
        sides = f"sides in {unit_name(found.lateral_unit)}"
    # files with one channel have the name "Default", by their reader
    name = "Default" if found.channel is None else found.channels[found.channel]
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
