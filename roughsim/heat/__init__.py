"""Heat of sliding: from the heat flux through the contact to the temperature of the bodies.

`periodic` repeats the cell for ever, `free` has one source and nothing around it, and shares the heat between two
bodies; `response` is what each mode answers with, `statistics` reads the fields. Each body occupies z > 0 below the
plane of the grid, and the source moves through it. The numbers of a run come from `observables`, which averages over
all directions in closed form; this room makes fields.
"""

from roughsim.heat.free.half_space import half_space_temperature
from roughsim.heat.free.partition import Body, Partition, partition_heat
from roughsim.heat.free.source import SourceTemperature, source_temperature
from roughsim.heat.periodic import sliding_temperature, uniform_temperature
from roughsim.heat.response import responses, unit_vector
from roughsim.heat.statistics import (
    contact_temperature,
    depth_profile,
    effective_conductivity,
    effective_temperature,
    hot_spots,
    hottest_pixel,
    profiles,
    share_above,
)

__all__ = [
    "Body",
    "Partition",
    "SourceTemperature",
    "contact_temperature",
    "depth_profile",
    "effective_conductivity",
    "effective_temperature",
    "half_space_temperature",
    "hot_spots",
    "hottest_pixel",
    "partition_heat",
    "profiles",
    "responses",
    "share_above",
    "sliding_temperature",
    "source_temperature",
    "uniform_temperature",
    "unit_vector",
]
