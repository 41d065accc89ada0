"""Scenes: simulated systems, read from a TOML file, checked, and converted to SI.

`load_scene` takes the name of a bundled scene or a path. A `Scene` is frozen and holds the content of all files that it
names; ``dataclasses.replace`` checks again. Only the properties of `Scene` combine the two bodies: composite modulus,
composite C(q), lower hardness. Every refusal is a `SceneError` of one line.
"""

from roughsim.scene.files import BLANK as BLANK
from roughsim.scene.files import SceneLike as SceneLike
from roughsim.scene.files import SceneSource as SceneSource
from roughsim.scene.files import as_scene as as_scene
from roughsim.scene.files import bundled_scenes as bundled_scenes
from roughsim.scene.files import load_scene as load_scene
from roughsim.scene.files import new as new
from roughsim.scene.files import parse_scene as parse_scene
from roughsim.scene.files import scene_text as scene_text
from roughsim.scene.files import with_short_tables as with_short_tables
from roughsim.scene.model import Scene as Scene
from roughsim.scene.schema import SceneError as SceneError
