"""Scenes: simulated systems, read from a TOML file, checked, and converted to SI.

`load_scene` takes the name of a bundled scene or a path. A `Scene` is frozen and holds the content of all files that it
names; ``dataclasses.replace`` checks again. Only the properties of `Scene` combine the two bodies: composite modulus,
composite C(q), lower hardness. Every refusal is a `SceneError` of one line.
"""

from roughsim.scene.files import (
    BLANK,
    SceneLike,
    SceneSource,
    as_scene,
    bundled_scenes,
    load_scene,
    new,
    parse_scene,
    scene_text,
    with_short_tables,
)
from roughsim.scene.model import Scene
from roughsim.scene.schema import SceneError

__all__ = [
    "BLANK",
    "Scene",
    "SceneError",
    "SceneLike",
    "SceneSource",
    "as_scene",
    "bundled_scenes",
    "load_scene",
    "new",
    "parse_scene",
    "scene_text",
    "with_short_tables",
]
