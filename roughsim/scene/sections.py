"""The sections of a scene file as frozen records, each checked when it is made or replaced."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any, Literal, Self, TypeVar

from pydantic import ConfigDict, ValidationError, ValidationInfo, field_validator, model_validator
from pydantic.dataclasses import dataclass

from roughsim.scene.messages import SceneError, one_line, refused_section, shown
from roughsim.scene.quantities import KEYS, Key, unit_of

STRICT = ConfigDict(extra="forbid")
Record = TypeVar("Record")
Rows = tuple[tuple[float, float], ...]
ROUGHNESS_KEYS = (
    "rms_height",
    "rms_slope",
    "psd",
    "psd_convention",
    "psd_source",
    "hurst",
    "q_min",
    "q_roll_off",
    "q_max",
    "roll_off_exponent",
    "spectrum",
)
_THERMAL_KEYS = ("conductivity", "density", "heat_capacity")
_WIDEST = 1e12  # q_max/q_min; a metre over the size of an atom is 1e10
_LEVELS_EXAMPLE = '[{ column = "capped", shape = 1024, q_max = "4e5 1/m" }]'
_KNOWN: dict[str, tuple[str, ...]] = {}
_OWN_KEYS: dict[str, Key] = {}  # of named spectra


def section(name: str, **own_keys: Key) -> Callable[[type[Record]], type[Record]]:
    """Register a record as the section `name` and let its constructor raise `SceneError` of one line.

    `own_keys` says how a named spectrum reads the keys that only it has.
    """
    for key, entry in own_keys.items():
        if KEYS.get(key, entry) != entry or _OWN_KEYS.setdefault(key, entry) != entry:
            raise ValueError(f"{key!r} is a key of scenes already, with other units or limits; choose another name")

    def register(record: type[Record]) -> type[Record]:
        keys = tuple(field.name for field in fields(record))  # type: ignore[arg-type]
        _KNOWN[name] = (*keys, "psd_file", "topography") if "psd" in keys else keys
        construct = record.__init__

        def checked(self: Record, *args: Any, **values: Any) -> None:
            try:
                construct(self, *args, **values)
            except ValidationError as error:
                examples = {key: entry.example for key, entry in (KEYS | _OWN_KEYS).items()}
                examples["levels"] = _LEVELS_EXAMPLE
                raise SceneError(one_line(error, name, _KNOWN, examples)) from None

        record.__init__ = checked  # type: ignore[method-assign, assignment]
        return record

    return register


def _read_value(cls: Any, value: Any, info: ValidationInfo) -> Any:
    """Read the value of a key as `KEYS` says; None stands for a key left out."""
    entry = (KEYS | _OWN_KEYS).get(info.field_name or "")
    return value if entry is None or value is None else entry(value)


def read_values() -> Any:
    """Return the validator by which each section reads its values."""
    return field_validator("*", mode="before")(_read_value)


@section("surface")
@dataclass(frozen=True, slots=True, kw_only=True, config=STRICT)
class SurfaceSection:
    """The roughness of one face; None is a key left out.

    Attributes
    ----------
    rms_height : float or None
        √⟨h²⟩, m; exactly one of this, `rms_slope` and `psd` is given.
    rms_slope : float or None
        √⟨|∇h|²⟩, dimensionless.
    psd : tuple of (float, float) or None
        Rows (q in rad/m, C in m⁴), what `psd_file` held or the map `topography` has.
    psd_convention : str or None
        "persson" (⟨h²⟩ = 2π ∫ q C dq) or "surfacetopography" (C is 4π² larger).
    psd_source : str or None
        "scan": the table was measured on one map, as by `topography`, so that its own error is unknown; None: it is
        taken as stated. No number depends on it, so it is not part of a scene's identity.
    hurst, q_min, q_roll_off, q_max, roll_off_exponent : float or None
        Shape of the self-affine C(q), see `roughsim.SelfAffineSpectrum`; wavenumbers in rad/m.
    spectrum : record or None
        A C(q) of `roughsim.scene.spectra` with its own keys, in place of all others.
    """

    rms_height: float | None = None
    rms_slope: float | None = None
    psd: Rows | None = None
    psd_convention: Literal["persson", "surfacetopography"] | None = None
    psd_source: Literal["scan"] | None = None
    hurst: float | None = None
    q_min: float | None = None
    q_roll_off: float | None = None
    q_max: float | None = None
    roll_off_exponent: float | None = None
    spectrum: Any = None
    _read = read_values()

    @model_validator(mode="after")
    def _fits(self) -> Self:
        _check_roughness(self)
        return self


@section("body")
@dataclass(frozen=True, slots=True, kw_only=True, config=STRICT)
class BodySection:
    """The moving body, whose temperature is reported.

    Attributes
    ----------
    youngs_modulus : float
        E, Pa.
    poisson_ratio : float
        ν in (−1, 0.5].
    penetration_hardness : float or None
        σ_P, Pa; None is elastic.
    conductivity : float or tuple of (float, float)
        κ, W/(m K), or rows (absolute temperature in K, κ), linear between.
    density : float
        ρ, kg/m³.
    heat_capacity : float
        c, J/(kg K).
    melting_temperature : float or None
        Absolute, K: a contact above it is warned of. No number depends on it, so it is not part of a scene's identity.
    """

    youngs_modulus: float
    poisson_ratio: float
    penetration_hardness: float | None = None
    conductivity: float | Rows
    density: float
    heat_capacity: float
    melting_temperature: float | None = None
    _read = read_values()


@section("counterface")
@dataclass(frozen=True, slots=True, kw_only=True, config=STRICT)
class CounterfaceSection:
    """The resting body: like the moving one, or its own keys of `SurfaceSection` and `BodySection`.

    Without surface keys it is smooth, without `youngs_modulus` rigid, without `conductivity` insulating. ``like =
    "body"`` is the same material with the same roughness, uncorrelated.
    """

    like: Literal["body"] | None = None
    rms_height: float | None = None
    rms_slope: float | None = None
    psd: Rows | None = None
    psd_convention: Literal["persson", "surfacetopography"] | None = None
    psd_source: Literal["scan"] | None = None
    hurst: float | None = None
    q_min: float | None = None
    q_roll_off: float | None = None
    q_max: float | None = None
    roll_off_exponent: float | None = None
    spectrum: Any = None
    youngs_modulus: float | None = None
    poisson_ratio: float | None = None
    penetration_hardness: float | None = None
    conductivity: float | Rows | None = None
    density: float | None = None
    heat_capacity: float | None = None
    melting_temperature: float | None = None
    _read = read_values()

    @property
    def rough(self) -> bool:
        """Whether the counterface has a roughness of its own keys."""
        return any(getattr(self, key) is not None for key in ROUGHNESS_KEYS)

    @model_validator(mode="after")
    def _fits(self) -> Self:
        given = [field.name for field in fields(self) if getattr(self, field.name) is not None]
        if not given:
            raise refused_section(
                'like is missing; write like = "body", give keys of its own, or leave the section out'
            )
        if self.like and len(given) > 1:
            raise refused_section(f'{given[1]} does not go with like = "body", which fixes it; remove one of the two')
        if self.rough:
            _check_roughness(self)
        _check_together(self, ("youngs_modulus", "poisson_ratio"))
        _check_together(self, _THERMAL_KEYS)
        return self


@section("sliding")
@dataclass(frozen=True, slots=True, kw_only=True, config=STRICT)
class SlidingSection:
    """Load, friction and speed.

    Attributes
    ----------
    nominal_pressure : float
        σ₀, Pa.
    friction_coefficient : float
        μ > 0.
    speed : tuple of float
        Sliding speeds, m/s, ≥ 0, all different; one number is read as a tuple of one.
    heat_partition : float or str
        Share of the heat into the moving body in (0, 1], or "mean", "total" or "all".
    duration : float or None
        Time since sliding began, s; None is steady.
    background_temperature : float or None
        T₀, the absolute temperature of both bodies without their flash temperatures, K; goes with a table κ(T) or a
        melting temperature.
    """

    nominal_pressure: float
    friction_coefficient: float
    speed: tuple[float, ...]
    heat_partition: float | Literal["mean", "total", "all"] = "all"
    duration: float | None = None
    background_temperature: float | None = None
    _read = read_values()

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.heat_partition == "total" and self.duration is None:
            raise refused_section(
                'heat_partition = "total" needs the time since sliding began; add for example duration = "1 ms"'
            )
        return self


@section("theory")
@dataclass(frozen=True, slots=True, kw_only=True, config=STRICT)
class TheorySection:
    """Input of the theory alone: γ in [0, 1] of W = P[γ + (1 − γ)P²]."""

    gamma: float = 0.45
    _read = read_values()


@section("ensemble")
@dataclass(frozen=True, slots=True, kw_only=True, config=STRICT)
class EnsembleSection:
    """How many realizations, and from which seed.

    Attributes
    ----------
    seed : int
        ≥ 0.
    max_realizations : int
        ≥ 1.
    until : tuple of (str, float)
        Pairs of an observable and the relative 95 % half-width it should reach.
    """

    seed: int = 1
    max_realizations: int = 400
    until: tuple[tuple[str, float], ...] = (("flash_temperature", 0.01),)
    _read = read_values()


@section("numerics.levels")
@dataclass(frozen=True, slots=True, kw_only=True, config=STRICT)
class LevelSection:
    """One level: which contact, on how many points (x, y), C(q) up to which wavenumber, rad/m, every how many times."""

    column: Literal["capped", "smoothed", "elastic"]
    shape: tuple[int, int]
    q_max: float
    every: int = 1
    _read = read_values()


@section("numerics")
@dataclass(frozen=True, slots=True, kw_only=True, config=STRICT)
class NumericsSection:
    """What the plan must not choose by itself; None leaves a choice to the plan. See `roughsim.Numerics`.

    Attributes
    ----------
    levels : tuple of LevelSection or None
        All levels, in order.
    lengths : (float, float) or None
        Sides of the periodic cell along x and y, m.
    tolerance : float or None
        Relative pressure error aimed at, in (0, 1).
    precision : str or None
        "double" or "single".
    solver : str or None
        Of the contact: a name of `roughsim.contact.methods`.
    slid_distance : float or None
        Distance slid from rest in temperature fields, m; may be inf.
    threads, keep_fields : int or None
        Threads per realization; number of realizations whose fields are kept.
    """

    levels: tuple[LevelSection, ...] | None = None
    lengths: tuple[float, float] | None = None
    tolerance: float | None = None
    precision: Literal["double", "single"] | None = None
    solver: str | None = None
    slid_distance: float | None = None
    threads: int | None = None
    keep_fields: int | None = None
    _read = read_values()

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.levels == ():
            raise refused_section(f"levels = [] holds no level; leave it out or write levels = {_LEVELS_EXAMPLE}")
        return self


def _check_roughness(face: Any) -> None:
    """Refuse a face whose C(q) is not fixed by its keys, or fixed twice."""
    given = [key for key in ("rms_height", "rms_slope", "psd", "spectrum") if getattr(face, key) is not None]
    names = [key.replace("psd", "psd_file") for key in given]
    if not given:
        raise refused_section("rms_height is missing; give exactly one of rms_height, rms_slope, psd_file and spectrum")
    if len(given) > 1:
        raise refused_section(f"{names[0]} and {names[1]} are both given; keep exactly one")
    if given == ["psd"]:
        _check_alone(face, "psd_file, whose table fixes C(q)")
        if face.psd_convention is None:
            raise refused_section(
                'psd_convention is missing; a table needs "persson" or "surfacetopography" (whose C is 4π² larger)'
            )
    elif given == ["spectrum"]:
        _check_alone(face, "spectrum, which has keys of its own")
        _check_no_table_keys(face)
    else:
        _check_no_table_keys(face)
        _check_band(face)


def _check_no_table_keys(face: Any) -> None:
    for key in ("psd_convention", "psd_source"):
        if getattr(face, key) is not None:
            raise refused_section(f"{key} goes with psd_file only; remove it")


def _check_alone(face: Any, what: str) -> None:
    for key in ("hurst", "q_min", "q_roll_off", "q_max", "roll_off_exponent"):
        if getattr(face, key) is not None:
            value = shown(getattr(face, key), unit_of(key))
            raise refused_section(f"{key} = {value} does not go with {what}; remove it")


def _check_band(face: Any) -> None:
    for key in ("hurst", "q_min", "q_max"):
        if getattr(face, key) is None:
            raise refused_section(f"{key} is missing; write for example {key} = {KEYS[key].example}")
    if face.q_min >= face.q_max:
        raise refused_section(
            f"q_min = {face.q_min:.6g} rad/m must be below q_max = {face.q_max:.6g} rad/m; change one of the two"
        )
    if face.q_max > _WIDEST * face.q_min:
        raise refused_section(
            f"q_max = {face.q_max:.6g} rad/m must be at most {_WIDEST:g} times q_min = {face.q_min:.6g} rad/m: beyond, "
            "integrals over the spectrum are lost in rounding; raise q_min or lower q_max"
        )
    if face.q_roll_off is not None and not face.q_min <= face.q_roll_off <= face.q_max:
        raise refused_section(
            f"q_roll_off = {face.q_roll_off:.6g} rad/m must lie between q_min = {face.q_min:.6g} rad/m and "
            f"q_max = {face.q_max:.6g} rad/m; change it or leave it out"
        )
    if face.roll_off_exponent and face.q_roll_off is None:
        raise refused_section(
            f"roll_off_exponent = {face.roll_off_exponent:g} needs q_roll_off; add it or leave the exponent out"
        )


def _check_together(record: Any, keys: tuple[str, ...]) -> None:
    missing = [key for key in keys if getattr(record, key) is None]
    if missing and len(missing) < len(keys):
        others = ", ".join(key for key in keys if key not in missing)
        raise refused_section(f"{missing[0]} is missing beside {others}; give all of {', '.join(keys)} or none")
