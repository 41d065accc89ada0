"""What follows from a scene, and where one of its numbers leaves what the model means.

A unit that slipped by a thousand gives a scene that computes without complaint. So the sizes that a reader can judge
are stated, and what lies beyond the model is told in one line each.
"""

from roughsim.plausibility.limits import Plausibility, judge
from roughsim.plausibility.sizes import Facts, facts

__all__ = ["Facts", "Plausibility", "facts", "judge"]
