"""A tiny scene of two rough faces that slide over one another."""

from small_scene import CAPPED

from roughsim.scene import parse_scene

LEVELS = """levels = [
  { column = "capped", shape = [32, 32], q_max = 2.5e4 },
  { column = "sliding", shape = [32, 32], q_max = 2.5e4, first = 2 },
]
"""
SLIDING = (
    CAPPED[: CAPPED.index("levels = [")].replace("speed = [0, 0.1, 35]", "speed = [1, 35]") + LEVELS
)
SLIDING = SLIDING.replace("max_realizations = 6", "max_realizations = 4")
MILLIMETRE = 'history = "sliding"\nslid_distance = "1 mm"'


def sliding_scene(history=MILLIMETRE, *changes):
    """The scene with a history, and with changes, each an old and a new text."""
    text = SLIDING.replace("heat_partition = 0.9\n", f"heat_partition = 0.9\n{history}\n")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return parse_scene(text)
