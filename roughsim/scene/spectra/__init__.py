"""Spectra C(q) that scenes can name: one file each, found by being in this folder.

The file NAME.py has a record `Spectrum`: the scene's keys with their limits, and C(q) as a callable with `breaks`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

from roughsim.scene.messages import SceneError, did_you_mean, refused_value, shown

NAMES = tuple(sorted(module.name for module in iter_modules(__path__)))


@dataclass(frozen=True, slots=True)
class NamedSpectrum:
    """The key `spectrum`: a name and the keys of that spectrum, kept as its record."""

    example: str = '{ name = "k_correlation", rms_height = "0.90 um", ... }'

    def __call__(self, value: Any) -> Any:
        """Return the record; a record is taken as it is."""
        name = value.get("name") if isinstance(value, Mapping) else getattr(value, "name", None)
        if not isinstance(name, str):
            raise refused_value(f" = {shown(value)} must be a table with a name, for example spectrum = {self.example}")
        if name not in NAMES:
            raise refused_value(f".name = {shown(name)} is no spectrum; {did_you_mean(name, NAMES)}")
        record = import_module(f"{__name__}.{name}").Spectrum
        if isinstance(value, record):
            return value
        try:
            return record(**value)
        except SceneError as error:
            where = f"spectrum.{name}"  # the outer section names itself
            raise refused_value(str(error).removeprefix(where).replace(f" in [{where}]", "")) from None
