"""Scene files: what is simulated (`Scene`), read from TOML, checked, and turned into SI.

`load_scene` takes the name of a bundled scene or a path. A `Scene` is frozen and holds everything it needs, files it
named included; ``dataclasses.replace`` checks again. The physics of two bodies (composite modulus, composite C(q), the
lower hardness) is in `Scene`'s properties and nowhere else. Every refusal is a `SceneError` of one line.
"""

from roughsim.scene.files import BLANK, bundled_scenes, load_scene, parse_scene, scene_text
from roughsim.scene.model import Scene, first_difference
from roughsim.scene.schema import SceneError

__all__ = [
    "BLANK",
    "Scene",
    "SceneError",
    "bundled_scenes",
    "first_difference",
    "load_scene",
    "parse_scene",
    "scene_text",
]
