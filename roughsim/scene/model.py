"""`Scene`: everything that is simulated, and the physics of two bodies."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, Self

import numpy as np
from pydantic import BeforeValidator, model_validator
from pydantic.dataclasses import dataclass
from pydantic_core import to_jsonable_python

from roughsim.scene import rules
from roughsim.scene.messages import SceneError, as_written
from roughsim.scene.numerics import NumericsSection
from roughsim.scene.records import Record
from roughsim.scene.sections import (
    BodySection,
    CounterfaceSection,
    EnsembleSection,
    SlidingSection,
    SurfaceSection,
    TheorySection,
    read_title,
)
from roughsim.scene.toml import scene_toml

if TYPE_CHECKING:
    from roughsim.surface.spectrum import Face, SumSpectrum

NOT_IDENTITY = {"ensemble.max_realizations", "ensemble.until", "numerics.keep_fields"} | {
    f"{face}.{key}"
    for face in ("surface", "body", "counterface")
    for key in ("psd_source", "melting_temperature")  # they change what is said of the numbers, and no number
}


class Conduction(NamedTuple):
    """κ, W/(m K), and D = κ/(ρc), m²/s, of the moving body and of the counterface; None if that is insulating."""

    conductivity: float
    diffusivity: float
    counter_conductivity: float | None
    counter_diffusivity: float | None


@dataclass(frozen=True, kw_only=True)
class Scene(Record, section=""):
    """What is simulated: frozen, in SI, checked when made and by ``dataclasses.replace``.

    Attributes
    ----------
    surface, body, counterface, sliding, theory, ensemble, numerics
        The sections of the file; `counterface` is None for a rigid, smooth and insulating one.
    title : str
        One line for people.

    Raises
    ------
    SceneError
        One line naming the key, its value, the limit and what to do.
    """

    title: Annotated[str, BeforeValidator(read_title)] = ""
    surface: SurfaceSection
    body: BodySection
    counterface: CounterfaceSection | None = None
    sliding: SlidingSection
    theory: TheorySection = TheorySection()
    ensemble: EnsembleSection = EnsembleSection()
    numerics: NumericsSection = NumericsSection()

    @model_validator(mode="after")
    def _fits(self) -> Self:
        rules.check_scene(self)
        rules.check_derived(self, map(diffusivities, self.bodies))
        return self

    @property
    def spectrum(self) -> Face | SumSpectrum:
        """Composite C(q) = C₁(q) + C₂(q) of the two uncorrelated faces, m⁴, Persson's convention."""
        faces = self.faces
        if len(faces) == 1:
            return faces[0]
        return faces[0].scaled(2.0) if faces[0] is faces[1] else faces[0] + faces[1]

    @property
    def faces(self) -> tuple[Face, ...]:
        """C(q) of each rough face, m⁴: one or two."""
        face, other = face_spectrum(self.surface), self.counterface
        if other is None or not (other.like or other.rough):
            return (face,)
        return (face, face if other.like else face_spectrum(other))

    @property
    def effective_modulus(self) -> float:
        """E* of 1/E* = Σ (1 − ν²)/E over both bodies, Pa; a rigid one adds nothing."""
        elastic = (body for body in self.bodies if body.youngs_modulus is not None)
        return 1.0 / sum((1.0 - body.poisson_ratio**2) / body.youngs_modulus for body in elastic)

    @property
    def penetration_hardness(self) -> float:
        """σ_P of the softer body, Pa; inf if both are elastic."""
        hardness = (body.penetration_hardness for body in self.bodies)
        return min((limit for limit in hardness if limit is not None), default=math.inf)

    @property
    def elastic(self) -> bool:
        """Whether no body has a hardness."""
        return math.isinf(self.penetration_hardness)

    @property
    def scanned(self) -> bool:
        """Whether a C(q) was measured on one map, so that nobody knows yet how far it is off."""
        faces = (self.surface, self.counterface)
        return any(face is not None and face.psd_source == "scan" for face in faces)

    @property
    def melting_temperature(self) -> float:
        """The lower one of the bodies that give theirs, absolute, K; inf if none does."""
        temperatures = (body.melting_temperature for body in self.bodies)
        return min((kelvin for kelvin in temperatures if kelvin is not None), default=math.inf)

    @property
    def counterface_conducts(self) -> bool:
        """Whether there is a second body that takes up heat."""
        return self.resting_body is not None and self.resting_body.conductivity is not None

    @property
    def temperature_range(self) -> tuple[float, float]:
        """Absolute temperatures, K, at which all conductivities are known: (0, inf) if they are numbers."""
        tables = [body.conductivity for body in self.bodies if isinstance(body.conductivity, tuple)]
        low, high = ([rows[end][0] for rows in tables] for end in (0, -1))
        return max(low, default=0.0), min(high, default=math.inf)

    def conduction(self, temperature: float | None = None) -> Conduction:
        """Return κ and D of both bodies at an absolute `temperature`, K, which is needed where a κ is a table.

        Raises
        ------
        SceneError
            If it is missing then, or not within `temperature_range`.
        """
        low, high = self.temperature_range
        if high < math.inf and (temperature is None or not low <= temperature <= high):
            raise SceneError(
                f"temperature = {as_written(temperature, 'K')} must lie between {low:g} K and {high:g} K, where the "
                "tables of conductivity are given"
            )
        bodies = [conduction_of(body, temperature) for body in self.bodies]
        return Conduction(*bodies[0], *(bodies[1] if self.counterface_conducts else (None, None)))

    @property
    def speeds(self) -> tuple[float, ...]:
        """Sliding speeds, m/s."""
        return self.sliding.speed

    @property
    def bodies(self) -> tuple[BodySection | CounterfaceSection, ...]:
        """The moving body, and the resting one if there is one."""
        return (self.body,) if self.resting_body is None else (self.body, self.resting_body)

    @property
    def resting_body(self) -> BodySection | CounterfaceSection | None:
        """The resting body's material."""
        return self.body if self.counterface is not None and self.counterface.like else self.counterface

    def identity(self) -> dict[str, Any]:
        """Return what makes this scene this one: physics, numerics and seed as dotted key → JSON value.

        Left out are the title; `ensemble.max_realizations`, `ensemble.until` and `numerics.keep_fields`, which say
        how long to go on and what to keep; and `psd_source`, the melting temperature and a background temperature
        without a table κ(T), which change what is said of the numbers only. Keys without a value are absent, except
        where absence has a meaning of its own as a number (``q_roll_off`` is then `q_min`, ``roll_off_exponent`` 0).
        """
        sections = to_jsonable_python(self, exclude={"title"}, exclude_none=True)
        flat = {f"{name}.{key}": value for name, section in sections.items() for key, value in section.items()}
        for face in ("surface", "counterface"):
            if f"{face}.q_min" in flat:
                flat.setdefault(f"{face}.q_roll_off", flat[f"{face}.q_min"])
                flat.setdefault(f"{face}.roll_off_exponent", 0.0)
        if math.isinf(self.temperature_range[1]):
            flat.pop("sliding.background_temperature", None)
        return {key: value for key, value in flat.items() if key not in NOT_IDENTITY}

    def to_toml(self) -> str:
        """Return a scene file that `load_scene` reads back to an equal scene, tables C(q) written inline."""
        return scene_toml(self)


def first_difference(a: Scene | Mapping[str, Any], b: Scene | Mapping[str, Any]) -> tuple[str, Any, Any] | None:
    """Return the first dotted key in which two scenes, or two identities, differ, with its value in `a` and in `b`.

    A value is None where the key is absent. Identities are what `Scene.identity` returned, possibly through JSON.
    """
    first = a.identity() if isinstance(a, Scene) else a
    second = b.identity() if isinstance(b, Scene) else b
    for key in dict.fromkeys((*first, *second)):
        if first.get(key) != second.get(key):
            return key, first.get(key), second.get(key)
    return None


def conduction_of(body: BodySection | CounterfaceSection, temperature: float | None) -> tuple[float, float]:
    """Return κ, W/(m K), and D, m²/s, of a body; κ is linear between the rows of a table."""
    kappa, density, capacity = body.conductivity, body.density, body.heat_capacity
    if kappa is None or density is None or capacity is None:
        return math.nan, math.nan
    if isinstance(kappa, tuple):
        kappa = float(np.interp(temperature or 0.0, *np.array(kappa).T))
    return kappa, kappa / (density * capacity)


def diffusivities(body: BodySection | CounterfaceSection) -> tuple[float, ...]:
    """Return D of a body, m²/s, at each temperature of its table; empty if it is insulating."""
    rows = body.conductivity if isinstance(body.conductivity, tuple) else ((None, body.conductivity),)
    return tuple(conduction_of(body, temperature)[1] for temperature, kappa in rows if kappa is not None)


def face_spectrum(face: SurfaceSection | CounterfaceSection) -> Face:
    """Return C(q) of one face, m⁴, in Persson's convention."""
    from roughsim.surface.power_laws import SelfAffineSpectrum, TabulatedSpectrum
    from roughsim.surface.spectrum import TruncatedSpectrum

    if face.spectrum is not None:
        return TruncatedSpectrum(face.spectrum)
    if face.psd is not None:
        q, psd = np.array(face.psd).T
        factor = 1.0 if face.psd_convention == "persson" else 1.0 / (4 * math.pi**2)
        return TabulatedSpectrum(q, psd).scaled(factor)
    shape: dict[str, Any] = {key: getattr(face, key) for key in ("hurst", "q_min", "q_max", "q_roll_off")}
    shape["roll_off_exponent"] = face.roll_off_exponent or 0.0
    if face.rms_height is not None:
        return SelfAffineSpectrum.from_rms_height(face.rms_height, **shape)
    return SelfAffineSpectrum.from_rms_slope(face.rms_slope, **shape)  # type: ignore[arg-type]
