"""Heat of sliding: from the heat flux through the contact to the temperature of the bodies.

`periodic` repeats the cell for ever, `free` has one source and nothing around it, and shares the heat between two
bodies; `response` is what each mode answers with, `statistics` reads the fields. Each body occupies z > 0 below the
plane of the grid, and the source moves through it. The numbers of a run come from `observables`, which averages over
all directions in closed form; this room makes fields.

The names below are imported when they are first asked for: a member of a run needs `response` alone.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "Body": "free.partition",
    "Partition": "free.partition",
    "SourceTemperature": "free.source",
    "contact_temperature": "statistics",
    "depth_profile": "statistics",
    "effective_conductivity": "statistics",
    "effective_temperature": "statistics",
    "half_space_temperature": "free.half_space",
    "hot_spots": "statistics",
    "partition_heat": "free.partition",
    "profiles": "statistics",
    "share_above": "statistics",
    "sliding_temperature": "periodic",
    "source_temperature": "free.source",
    "uniform_temperature": "periodic",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'roughsim.heat' has no attribute {name!r}")
    return getattr(import_module(f"roughsim.heat.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(_HOME)
