"""What the studies of the tests vary, and the description of such a study."""

from roughsim.studies.folder import describe
from roughsim.studies.work import scenes_of

LOADS = [1e8, 1.2e8, 3e8]
VARY = {"sliding.nominal_pressure": LOADS, "sliding.friction_coefficient": [0.1, 0.2]}


def description_of(scene, vary=VARY):
    """What study.json says of a study without a target."""
    axes, scenes = scenes_of(scene, vary)
    return describe(scenes, axes, None)
