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

GROUP = "roughsim.spectra"
INSIDE = {"k_correlation": "roughsim.scene.spectra.k_correlation:Spectrum"}
EXAMPLE = '{ name = "k_correlation", rms_height = "0.90 um", ... }'


def spectra() -> dict[str, str]:
    """Return where the record of each spectrum is, as "module:name"; a name of the package cannot be taken."""
    return {entry.name: entry.value for entry in entry_points(group=GROUP)} | INSIDE


def read_spectrum(value: Any) -> Any:
    """Return the record of a table with a name and the keys of that spectrum; a record is taken as it is."""
    name = value.get("name") if isinstance(value, Mapping) else getattr(value, "name", None)
    if not isinstance(name, str):
        raise ValueError(f" = {as_written(value)} must be a table with a name, for example spectrum = {EXAMPLE}")
    known = INSIDE if name in INSIDE else spectra()  # what is installed is looked through only where it may matter
    if name not in known:
        raise ValueError(f".name = {as_written(name)} is no spectrum; {did_you_mean(name, known)}")
    record = resolve_name(known[name])
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
