"""Heat of sliding: from the heat flux through the contact to the temperature of the bodies.

`periodic` repeats the cell for ever, `half_space` has one source and nothing around it, `source` gives T_flash, T_av
and T_max of that one, `partition` shares the heat between the two bodies, `statistics` reads the fields. Each body
occupies z > 0 below the plane of the grid, and the source moves through it.
"""

from roughsim.heat.half_space import half_space_temperature
from roughsim.heat.partition import Body, Partition, partition_heat
from roughsim.heat.periodic import responses, sliding_temperature, uniform_temperature, unit_vector
from roughsim.heat.source import SourceTemperature, source_temperature
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
