"""`Scene`: everything that is simulated, and the physics of two bodies."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from pydantic import model_validator
from pydantic.dataclasses import dataclass

from roughsim.scene.messages import SceneError, refused_section, shown
from roughsim.scene.quantities import MAX_ROWS
from roughsim.scene.sections import (
    STRICT,
    BodySection,
    CounterfaceSection,
    EnsembleSection,
    NumericsSection,
    SlidingSection,
    SurfaceSection,
    TheorySection,
    read_values,
    section,
)

if TYPE_CHECKING:
    from roughsim.surface.spectrum import Face, SumSpectrum

_NOT_IDENTITY = {"title", "ensemble.max_realizations", "ensemble.until", "numerics.keep_fields"} | {
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


@section("")
@dataclass(frozen=True, slots=True, kw_only=True, config=STRICT)
class Scene:
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

    title: str = ""
    surface: SurfaceSection
    body: BodySection
    counterface: CounterfaceSection | None = None
    sliding: SlidingSection
    theory: TheorySection = TheorySection()
    ensemble: EnsembleSection = EnsembleSection()
    numerics: NumericsSection = NumericsSection()
    _read = read_values()

    @model_validator(mode="after")
    def _fits(self) -> Self:
        _check_load(self)
        _check_partition(self)
        _check_conductivity(self)
        _check_levels(self)
        _check_derived(self)
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
        face, other = _face_spectrum(self.surface), self.counterface
        if other is None or not (other.like or other.rough):
            return (face,)
        return (face, face if other.like else _face_spectrum(other))

    @property
    def effective_modulus(self) -> float:
        """E* of 1/E* = Σ (1 − ν²)/E over both bodies, Pa; a rigid one adds nothing."""
        other = self._resting
        compliance = _compliance(self.body.youngs_modulus, self.body.poisson_ratio)
        if other is not None and other.youngs_modulus is not None and other.poisson_ratio is not None:
            compliance += _compliance(other.youngs_modulus, other.poisson_ratio)
        return 1.0 / compliance

    @property
    def penetration_hardness(self) -> float:
        """σ_P of the softer body, Pa; inf if both are elastic."""
        bodies = (self.body, self._resting)
        hardness = [b.penetration_hardness for b in bodies if b is not None and b.penetration_hardness is not None]
        return min(hardness, default=math.inf)

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
        given = [body.melting_temperature for body in self._bodies if body.melting_temperature is not None]
        return min(given, default=math.inf)

    @property
    def diffusivity(self) -> float:
        """D = κ/(ρc) of the moving body, m²/s; SceneError where a κ is a table, as for the next two."""
        return self.conduction().diffusivity

    @property
    def counter_conductivity(self) -> float | None:
        """κ of the counterface, W/(m K); None if it is insulating."""
        return self.conduction().counter_conductivity

    @property
    def counter_diffusivity(self) -> float | None:
        """D = κ/(ρc) of the counterface, m²/s; None if it is insulating."""
        return self.conduction().counter_diffusivity

    @property
    def counterface_conducts(self) -> bool:
        """Whether there is a second body that takes up heat."""
        return self._resting is not None and self._resting.conductivity is not None

    @property
    def temperature_range(self) -> tuple[float, float]:
        """Absolute temperatures, K, at which all conductivities are known: (0, inf) if they are numbers."""
        tables = [body.conductivity for body in self._bodies if isinstance(body.conductivity, tuple)]
        low, high = ([rows[end][0] for rows in tables] for end in (0, -1))
        return max(low, default=0.0), min(high, default=math.inf)

    def conduction(self, temperature: float | None = None) -> Conduction:
        """Return κ and D of both bodies.

        Parameters
        ----------
        temperature : float, optional
            Absolute temperature, K, within `temperature_range`; needed where a conductivity is a table.

        Raises
        ------
        SceneError
            A temperature that is missing or not within the tables.
        """
        low, high = self.temperature_range
        if high < math.inf and (temperature is None or not low <= temperature <= high):
            raise SceneError(
                f"temperature = {shown(temperature, 'K')} must lie between {low:g} K and {high:g} K, where the tables "
                "of conductivity are given"
            )
        bodies = [_conduction(body, temperature) for body in self._bodies]
        return Conduction(*bodies[0], *(bodies[1] if self.counterface_conducts else (None, None)))

    @property
    def speeds(self) -> tuple[float, ...]:
        """Sliding speeds, m/s."""
        return self.sliding.speed

    @property
    def _bodies(self) -> tuple[BodySection | CounterfaceSection, ...]:
        """The moving body, and the resting one if there is one."""
        return (self.body,) if self._resting is None else (self.body, self._resting)

    @property
    def _resting(self) -> BodySection | CounterfaceSection | None:
        """The resting body's material."""
        return self.body if self.counterface is not None and self.counterface.like else self.counterface

    def identity(self) -> dict[str, Any]:
        """Return what makes this scene this one: physics, numerics and seed as dotted key → JSON value.

        Left out are the title; `ensemble.max_realizations`, `ensemble.until` and `numerics.keep_fields`, which say
        how long to go on and what to keep; and `psd_source`, the melting temperature and a background temperature
        without a table κ(T), which change what is said of the numbers only. Keys without a value are absent, except
        where absence has a meaning of its own as a number (``q_roll_off`` is then `q_min`, ``roll_off_exponent`` 0).
        """
        flat: dict[str, Any] = {}
        for name in (field.name for field in fields(self)):
            if name != "title" and getattr(self, name) is not None:
                flat |= {f"{name}.{key}": value for key, value in _plain(getattr(self, name)).items()}
        for face in ("surface", "counterface"):
            if f"{face}.q_min" in flat:
                flat.setdefault(f"{face}.q_roll_off", flat[f"{face}.q_min"])
                flat.setdefault(f"{face}.roll_off_exponent", 0.0)
        if math.isinf(self.temperature_range[1]):
            flat.pop("sliding.background_temperature", None)
        return {key: value for key, value in flat.items() if key not in _NOT_IDENTITY}

    def to_toml(self) -> str:
        """Return a scene file that `load_scene` reads back to an equal scene, tables C(q) written inline."""
        from roughsim.scene.toml import scene_toml

        return scene_toml(self)


def first_difference(a: Scene | Mapping[str, Any], b: Scene | Mapping[str, Any]) -> tuple[str, Any, Any] | None:
    """Return the first key in which two scenes, or two identities, differ.

    Parameters
    ----------
    a, b : Scene or mapping
        Scenes, or what `Scene.identity` returned (possibly through JSON).

    Returns
    -------
    (str, value, value) or None
        The dotted key and its value in `a` and in `b`, None where it is absent; None if there is no difference.
    """
    first = a.identity() if isinstance(a, Scene) else a
    second = b.identity() if isinstance(b, Scene) else b
    for key in dict.fromkeys((*first, *second)):
        if first.get(key) != second.get(key):
            return key, first.get(key), second.get(key)
    return None


def _plain(value: Any) -> Any:
    """Turn records into dicts without their absent keys, tuples into lists, and inf into a string: JSON values."""
    if hasattr(value, "__dataclass_fields__"):
        items = ((field.name, getattr(value, field.name)) for field in fields(value))
        return {key: _plain(entry) for key, entry in items if entry is not None}
    if isinstance(value, tuple):
        return [_plain(entry) for entry in value]
    return "inf" if isinstance(value, float) and math.isinf(value) else value


def _conduction(body: BodySection | CounterfaceSection, temperature: float | None) -> tuple[float, float]:
    """κ and D of a body; κ is linear between the rows of a table."""
    kappa, density, capacity = body.conductivity, body.density, body.heat_capacity
    if kappa is None or density is None or capacity is None:
        return math.nan, math.nan
    if isinstance(kappa, tuple):
        kappa = float(np.interp(temperature or 0.0, *np.array(kappa).T))
    return kappa, kappa / (density * capacity)


def _diffusivities(body: BodySection | CounterfaceSection) -> list[float]:
    """D of a body at each temperature of its table; none if it is insulating."""
    rows = body.conductivity if isinstance(body.conductivity, tuple) else ((None, body.conductivity),)
    return [_conduction(body, temperature)[1] for temperature, kappa in rows if kappa is not None]


def _compliance(youngs_modulus: float, poisson_ratio: float) -> float:
    return (1.0 - poisson_ratio**2) / youngs_modulus


def _face_spectrum(face: SurfaceSection | CounterfaceSection) -> Face:
    """C(q) of one face, m⁴, Persson's convention."""
    from roughsim.surface.spectrum import SelfAffineSpectrum, TabulatedSpectrum, TruncatedSpectrum

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


def _check_load(scene: Scene) -> None:
    load, hardness = scene.sliding.nominal_pressure, scene.penetration_hardness
    if load > hardness:
        softer = "body" if scene.body.penetration_hardness == hardness else "counterface"
        raise refused_section(
            f"sliding.nominal_pressure = {load:.6g} Pa exceeds {softer}.penetration_hardness = {hardness:.6g} Pa, "
            "which no contact can carry; lower the pressure or raise the hardness"
        )


def _check_partition(scene: Scene) -> None:
    rule = scene.sliding.heat_partition
    if rule in ("mean", "total") and not scene.counterface_conducts:
        missing = "[counterface]" if scene.counterface is None else "counterface.conductivity"
        raise refused_section(
            f'sliding.heat_partition = "{rule}" shares the heat with a second body, but {missing} is missing; add it '
            '(like = "body" for the same material), or write "all" or a number'
        )


def _check_conductivity(scene: Scene) -> None:
    low, high = scene.temperature_range
    start = scene.sliding.background_temperature
    if start is None and high < math.inf:
        raise refused_section(
            "sliding.background_temperature is missing; a conductivity that is a table over temperature needs it: add "
            'for example background_temperature = "300 K"'
        )
    if start is not None and min(high, scene.melting_temperature) == math.inf:
        raise refused_section(
            f"sliding.background_temperature = {start:g} K goes with a conductivity that is a table over temperature, "
            "or with a melting_temperature; remove it"
        )
    if start is not None and not low <= start <= high:
        raise refused_section(
            f"sliding.background_temperature = {start:g} K must lie between {low:g} K and {high:g} K, where the tables "
            "of conductivity are given; extend them"
        )


def _check_levels(scene: Scene) -> None:
    for number, level in enumerate(scene.numerics.levels or ()):
        if scene.elastic and level.column != "elastic":
            raise refused_section(
                f'numerics.levels[{number}].column = "{level.column}" needs a body.penetration_hardness; add it or '
                'write "elastic"'
            )


def _check_derived(scene: Scene) -> None:
    faces = [scene.surface, scene.counterface]
    rows = sum(len(face.psd) for face in faces if face is not None and face.psd is not None)
    if rows > MAX_ROWS:
        raise refused_section(
            f"counterface.psd and surface.psd together have {rows} rows, above the limit of {MAX_ROWS}; average C over "
            "bins of log q"
        )
    try:
        derived = [
            ("rms height", scene.spectrum.rms_height, "m"),
            ("rms slope", scene.spectrum.rms_slope, ""),
            ("effective modulus", scene.effective_modulus, "Pa"),
        ]
        for name, body in zip(("diffusivity", "diffusivity of the counterface"), scene._bodies, strict=False):
            derived += [(name, value, "m²/s") for value in _diffusivities(body)]
    except (ArithmeticError, ValueError) as error:
        raise refused_section(
            f"surface or body: numbers beyond what can be computed with ({error}); check them"
        ) from None
    for name, value, unit in derived:
        if not 0.0 < value < math.inf:
            raise refused_section(
                f"surface or body: the {name} becomes {value:.6g} {unit}; check the numbers it is made of"
            )
