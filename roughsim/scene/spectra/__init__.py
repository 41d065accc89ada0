"""Spectra C(q) that a scene names: ``spectrum = { name = "...", ... }`` in a section with a roughness.

The record of a spectrum has the scene's keys as its fields, and is C(q) as a callable with `breaks`. A spectrum of the
package stands in `INSIDE`; one of another package is an entry point of the group "roughsim.spectra".
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import entry_points
from pkgutil import resolve_name
from typing import Any

from roughsim.scene.schema import SECTIONS, SceneError, as_written, did_you_mean, quantity

INSIDE = {"k_correlation": "roughsim.scene.spectra.k_correlation:Spectrum"}
EXAMPLE = '{ name = "k_correlation", rms_height = "0.90 um", ... }'


def read_spectrum(value: Any) -> Any:
    """Return the record of a table with a name and the keys of that spectrum; a record is taken as it is."""
    name = value.get("name") if isinstance(value, Mapping) else getattr(value, "name", None)
    if not isinstance(name, str):
        raise ValueError(f" = {as_written(value)} must be a table with a name, for example spectrum = {EXAMPLE}")
    homes = INSIDE  # its names come first, so that no other package replaces a spectrum of this one
    if name not in INSIDE:
        homes = {entry.name: entry.value for entry in entry_points(group="roughsim.spectra")} | INSIDE
    if name not in homes:
        raise ValueError(f".name = {as_written(name)} is no spectrum; {did_you_mean(name, homes)}")
    record = resolve_name(homes[name])
    if isinstance(value, record):
        return value
    surface = SECTIONS["surface"]
    for key in {*record.known_keys()} & {*surface.known_keys()}:
        if quantity(record, key) != quantity(surface, key):
            raise ValueError(f".{key} has another unit or other limits than in [surface]; the spectrum must rename it")
    try:
        return record(**value)
    except SceneError as error:
        raise ValueError(f".{error}") from None  # the record does not know where in the scene it stands
