"""Heat of sliding: from the heat flux through the contact to temperature fields of the bodies.

`periodic` is for the periodic cell. `half_space` is for one source with nothing around it; `influence` is the
temperature around one heated pixel there, and `partition` shares the heat between two bodies. `statistics` evaluates
temperature fields. Each body occupies z > 0 below the plane of the grid, and the source moves through it. The means
that a run reports come from `observables`, which averages over all directions in closed form.
"""

from roughsim.heat.half_space import SourceTemperature as SourceTemperature
from roughsim.heat.half_space import half_space_temperature as half_space_temperature
from roughsim.heat.half_space import source_temperature as source_temperature
from roughsim.heat.partition import Body as Body
from roughsim.heat.partition import Partition as Partition
from roughsim.heat.partition import partition_heat as partition_heat
from roughsim.heat.periodic import sliding_temperature as sliding_temperature
from roughsim.heat.periodic import uniform_temperature as uniform_temperature
from roughsim.heat.statistics import contact_temperature as contact_temperature
from roughsim.heat.statistics import depth_profile as depth_profile
from roughsim.heat.statistics import effective_conductivity as effective_conductivity
from roughsim.heat.statistics import effective_temperature as effective_temperature
from roughsim.heat.statistics import hot_spots as hot_spots
from roughsim.heat.statistics import joint_distribution as joint_distribution
from roughsim.heat.statistics import profiles as profiles
from roughsim.heat.statistics import rms_temperature as rms_temperature
from roughsim.heat.statistics import share_above as share_above
from roughsim.heat.statistics import temperature_correlation as temperature_correlation
from roughsim.heat.statistics import wake_profile as wake_profile
