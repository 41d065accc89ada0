"""Heat of sliding: from the heat flux through the contact to temperature fields of the bodies.

`periodic` is for the periodic cell. `half_space` is for one source with nothing around it; `influence` is the
temperature around one heated pixel there, and `partition` shares the heat between two bodies. `statistics` evaluates
temperature fields. Each body occupies z > 0 below the plane of the grid, and the source moves through it. The means
that a run reports come from `observables`, which averages over all directions in closed form.
"""

from roughsim.heat.body import Body
from roughsim.heat.half_space import (
    SourceTemperature,
    half_space_temperature,
    source_temperature,
)
from roughsim.heat.partition import (
    Partition,
    partition_heat,
)
from roughsim.heat.periodic import (
    sliding_temperature,
    uniform_temperature,
)
from roughsim.heat.statistics import (
    contact_temperature,
    depth_profile,
    effective_conductivity,
    effective_temperature,
    hot_spots,
    joint_distribution,
    profiles,
    rms_temperature,
    share_above,
    temperature_correlation,
    wake_profile,
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
    "joint_distribution",
    "partition_heat",
    "profiles",
    "rms_temperature",
    "share_above",
    "sliding_temperature",
    "source_temperature",
    "temperature_correlation",
    "uniform_temperature",
    "wake_profile",
]
