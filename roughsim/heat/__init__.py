"""Heat of sliding: from the heat flux through the contact to temperature fields of the bodies.

`periodic` is for the periodic cell. `half_space` is for one source with nothing around it; `influence` is the
temperature around one heated pixel there, and `partition` shares the heat between two bodies. `statistics` evaluates
temperature fields. Each body occupies z > 0 below the plane of the grid, and the source moves through it. The means
that a run reports come from `observables`, which averages over all directions in closed form.

A module is imported when one of its names is first used: a member of a run needs `periodic` alone.
"""

from importlib import import_module
from typing import Any

_NAMES = {
    "half_space": "SourceTemperature half_space_temperature source_temperature",
    "partition": "Body Partition partition_heat",
    "periodic": "sliding_temperature uniform_temperature",
    "statistics": "contact_temperature depth_profile effective_conductivity effective_temperature hot_spots profiles "
    "share_above",
}


def __getattr__(name: str) -> Any:
    for module, names in _NAMES.items():
        if name in names.split():
            return getattr(import_module(f"roughsim.heat.{module}"), name)
    raise AttributeError(f"module 'roughsim.heat' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(" ".join(_NAMES.values()).split())
