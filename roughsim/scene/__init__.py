"""Scene files: what is simulated (`Scene`), read from TOML, checked, and turned into SI.

`load_scene` takes the name of a bundled scene or a path. A `Scene` is frozen and holds everything it needs, files it
named included; ``dataclasses.replace`` checks again. The physics of two bodies (composite modulus, composite C(q), the
lower hardness) is in `Scene`'s properties and nowhere else. Every refusal is a `SceneError` of one line.
"""

from roughsim.scene.files import BLANK as BLANK
from roughsim.scene.files import bundled_scenes as bundled_scenes
from roughsim.scene.files import load_scene as load_scene
from roughsim.scene.files import parse_scene as parse_scene
from roughsim.scene.files import scene_text as scene_text
from roughsim.scene.model import Scene as Scene
from roughsim.scene.schema import SceneError as SceneError
