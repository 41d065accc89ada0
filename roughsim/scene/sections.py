"""The sections of a scene file: each key with its unit, its limits and its meaning.

A key that is left out is None, or has the default given here. The section [numerics] is in `roughsim.scene.numerics`.
"""

import re
from collections.abc import Mapping, Sequence
from math import pi, remainder, tau
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, model_validator

from roughsim.extensions import extensions, loaded
from roughsim.scene.scans import MEASURED_KEYS, ScanOptions
from roughsim.scene.schema import (
    KELVIN,
    SECTIONS,
    Hurst,
    QMax,
    QMin,
    QRollOff,
    Quantity,
    Record,
    RmsHeight,
    SceneError,
    as_written,
    did_you_mean,
    example,
    one_or_list,
    optional_keys,
    quantity,
    record,
    unit_of,
)
from roughsim.scene.skins import HeatDepth, SkinSection
from roughsim.scene.tables import (
    Conductivity,
    FrictionCoefficient,
    PsdDirections,
    PsdError,
    PsdTexture,
    Rows,
    read_psd,
)

_SHARE = Quantity("", "0.938", gt=0, le=1)
_SHARE_RULES = ("mean", "total", "all")
SPEED = Quantity("m/s", '"35 m/s"', ge=0)
_SELF_AFFINE_KEYS = ("hurst", "q_min", "q_roll_off", "q_max", "roll_off_exponent")
_SIZE_KEYS = (
    "rms_height",
    "rms_slope",
    "psd",
    "spectrum",
)  # one of them gives the roughness of a face
_PSD_KEYS = ("psd_convention", "psd_directions", *MEASURED_KEYS)  # they go with `psd`
ROUGHNESS_KEYS = (*_SIZE_KEYS, *_PSD_KEYS, *_SELF_AFFINE_KEYS, "lay", "lay_direction")
_THERMAL_KEYS = ("conductivity", "density", "heat_capacity")
# keys of the end of a run, of kept fields, and of sources and warnings: they change no number
NOT_IDENTITY = (
    "ensemble.realizations",
    "ensemble.max_realizations",
    "ensemble.until",
    "numerics.keep_fields",
    "body.melting_temperature",
    "counterface.melting_temperature",
    *(f"{face}.{key}" for face in ("surface", "counterface") for key in MEASURED_KEYS),
)
SAME_ANGLE = 1e-9  # rad
_TURN = 6.2832  # rad, 360° rounded up
_LONGEST_LAY = 20.0  # the longest grooves whose ends a cell still has
_ANGLE = Quantity("rad", '"30 deg"', ge=-_TURN, le=_TURN)
_WIDEST_BAND = 1e12  # q_max/q_min; a metre over the size of an atom is 1e10


def _read_spectrum(value: Any) -> Any:
    """Read a table with the name and the keys of a C(q); return its `Record`, which is callable and has `breaks`."""
    name = value.get("name") if isinstance(value, Mapping) else getattr(value, "name", None)
    if not isinstance(name, str):
        example = 'spectrum = { name = "k_correlation", rms_height = "0.90 um", ... }'
        raise ValueError(
            f" = {as_written(value)} must be a table with a name, for example {example}"
        )
    if name not in (spectra := extensions("spectra")):
        raise ValueError(
            f".name = {as_written(name)} is no spectrum; {did_you_mean(name, spectra)}"
        )
    record = loaded("spectra", name)
    if isinstance(value, record):
        return value
    surface = SECTIONS["surface"]
    for key in {*record.known_keys()} & {*surface.known_keys()}:
        if quantity(record, key) != quantity(surface, key):
            raise ValueError(
                f".{key} has another unit or other limits than in [surface]; the spectrum must rename it"
            )
    try:
        return record(**value)
    except SceneError as error:
        raise ValueError(f".{error}") from None  # the record has no name of its key in the scene


def _refuse_table_of_hardness(value: Any) -> Any:
    """Return any value but a table over temperature."""
    if isinstance(value, Mapping):
        raise ValueError(
            " is a table over temperature, with which each speed would have a contact of its own; give a scene of one "
            "speed the hardness at the temperature of its contact, as docs/partition.md computes it"
        )
    return value


def _check_speeds(speeds: tuple[float, ...]) -> tuple[float, ...]:
    """Return speeds; refuse one that is there twice."""
    for i, speed in enumerate(speeds):
        if speed in speeds[:i]:
            raise ValueError(f"[{i}] = {speed:g} m/s is there twice; remove one of the two")
    return speeds


def _check_directions(directions: tuple[float, ...]) -> tuple[float, ...]:
    """Return directions, rad; refuse one that is there twice."""
    for i, angle in enumerate(directions):
        if any(abs(remainder(angle - other, tau)) < SAME_ANGLE for other in directions[:i]):
            raise ValueError(
                f"[{i}] = {angle:.6g} rad is there twice, if not by another turn; remove one of the two"
            )
    return directions


def _check_lay(lay: float) -> float:
    """Return a lay; refuse one of less than 1, and grooves without end."""
    if lay < 1.0:
        raise ValueError(
            f" = {lay:g} must be at least 1: it is the ratio of lengths along the grooves and across; write "
            f"{1 / lay:.4g}, with lay_direction turned by 90 deg"
        )
    if lay > _LONGEST_LAY:
        raise ValueError(
            f" = {lay:g} must be at most {_LONGEST_LAY:g}: such grooves are longer than a map; press a map of the face"
        )
    return lay


def _read_share(value: Any) -> float | str:
    """Read a share of the heat, or the name of a rule that gives it."""
    if not isinstance(value, str) or re.match(r"\s*[-+.0-9]", value):
        return float(_SHARE(value))
    if value not in _SHARE_RULES:
        raise ValueError(
            f" = {as_written(value)} is not known; {did_you_mean(value, _SHARE_RULES)}"
        )
    return value


def read_title(value: Any) -> str:
    """Read one line of text."""
    if not isinstance(value, str) or not value.isprintable() or len(value) > 200:
        raise ValueError(
            f' = {as_written(value)} must be one line of at most 200 characters, as "Steel on steel"'
        )
    return value


def _check_roughness(face: "SurfaceSection") -> "SurfaceSection":
    """Return a face; refuse keys that do not fix its C(q), or fix it twice."""
    sizes = [key for key in _SIZE_KEYS if getattr(face, key) is not None]
    if not sizes:
        raise ValueError(
            "rms_height is missing; give exactly one of rms_height, rms_slope, psd_file and spectrum"
        )
    if len(sizes) > 1:
        first, second = (key.replace("psd", "psd_file") for key in sizes[:2])
        raise ValueError(f"{first} and {second} are both given; keep exactly one")
    if sizes[0] in ("psd", "spectrum"):
        fixed = (
            "psd_file, whose table fixes C(q)"
            if face.psd
            else "spectrum, which has keys of its own"
        )
        for key in _SELF_AFFINE_KEYS:
            if getattr(face, key) is not None:
                value = as_written(getattr(face, key), unit_of(type(face), key))
                raise ValueError(f"{key} = {value} does not go with {fixed}; remove it")
    _check_table(face)
    if face.lay_direction is not None and face.lay is None:
        raise ValueError(
            f"lay_direction = {face.lay_direction:.6g} rad goes with lay; add it or remove the direction"
        )
    of_lines = face.psd_scans and not face.psd_texture  # line scans in directions
    if face.lay is not None and face.psd_source == "scan" and not of_lines:
        raise ValueError(
            f"lay = {face.lay:g} does not go with a scan, which has a lay of its own; remove it"
        )
    if sizes[0] in ("rms_height", "rms_slope"):
        _check_band(face)
    return face


def _check_table(face: "SurfaceSection") -> None:
    """Refuse a table C(q) without its convention, keys of a table without one, and errors of other rows."""
    for key in _PSD_KEYS:
        if not face.psd and getattr(face, key) is not None:
            raise ValueError(f"{key} goes with psd_file only; remove it")
    if face.psd and face.psd_convention is None:
        raise ValueError(
            'psd_convention is missing; a table needs "persson", "surfacetopography" (C is 4π² larger), "frequency" (C '
            'over the spatial frequency f = q/2π, in place of q) or "profile" (of lines, in m³)'
        )
    if face.psd_convention == "profile":
        raise ValueError(
            'psd_convention = "profile" is converted by roughsim.load_scene alone; load a scene'
        )
    if face.psd_error is not None and len(face.psd_error) != (rows := len(face.psd or ())):
        raise ValueError(
            f"psd_error has {len(face.psd_error)} rows and psd {rows}; give one for each"
        )


def _check_band(face: "SurfaceSection") -> None:
    """Refuse a self-affine C(q) whose wavenumbers are missing or out of order."""
    for key in ("hurst", "q_min", "q_max"):
        if getattr(face, key) is None:
            raise ValueError(f"{key} is missing; write for example {example(type(face), key)}")
    if face.q_min is None or face.q_max is None:  # refused above
        return
    q_min = f"q_min = {face.q_min:.6g} rad/m"
    q_max = f"q_max = {face.q_max:.6g} rad/m"
    if face.q_min >= face.q_max:
        raise ValueError(f"{q_min} must be below {q_max}; change one of the two")
    if face.q_max > _WIDEST_BAND * face.q_min:
        raise ValueError(
            f"{q_max} must be at most {_WIDEST_BAND:g} times {q_min}: beyond, integrals over the spectrum are lost in "
            "rounding; raise q_min or lower q_max"
        )
    if face.q_roll_off is not None and not face.q_min <= face.q_roll_off <= face.q_max:
        raise ValueError(
            f"q_roll_off = {face.q_roll_off:.6g} rad/m must lie between {q_min} and {q_max}; change it or leave it out"
        )
    if face.roll_off_exponent and face.q_roll_off is None:
        raise ValueError(
            f"roll_off_exponent = {face.roll_off_exponent:g} needs q_roll_off; add it or leave the exponent out"
        )


def _check_counterface(counterface: "CounterfaceSection") -> "CounterfaceSection":
    """Return a counterface; refuse one without keys, with keys beside `like`, or with half of a material."""
    keys = [
        key
        for key in counterface.known_keys()
        if key != "temperature" and getattr(counterface, key, None) is not None
    ]
    if not keys:
        raise ValueError(
            'like is missing; write like = "body", give keys of its own, or leave the section out'
        )
    if counterface.like and len(keys) > 1:
        other = next(key for key in keys if key != "like")
        raise ValueError(
            f'{other} does not go with like = "body", which fixes it; remove one of the two'
        )
    if counterface.rough:
        _check_roughness(counterface)
    _check_all_or_none(keys, ("youngs_modulus", "poisson_ratio"))
    _check_all_or_none(keys, _THERMAL_KEYS)
    layer = next((key for key in ("skin", "heat_depth") if key in keys), None)
    if layer and counterface.conductivity is None:
        raise ValueError(
            f"{layer} goes with a counterface that takes heat; give its {', '.join(_THERMAL_KEYS)} too"
        )
    return counterface


def _check_all_or_none(keys: Sequence[str], together: Sequence[str]) -> None:
    """Refuse keys that are only a part of the keys of one material."""
    given = [key for key in together if key in keys]
    missing = [key for key in together if key not in keys]
    if given and missing:
        raise ValueError(
            f"{missing[0]} is missing beside {', '.join(given)}; give all of {', '.join(together)} or none"
        )


@record("surface")
class SurfaceSection(Record):
    """The roughness of one face."""

    rms_height: RmsHeight | None = None
    """√⟨h²⟩; exactly one of this, `rms_slope`, `psd` and `spectrum` is given."""
    rms_slope: Annotated[float, Quantity("", "0.3", gt=0)] | None = None
    """√⟨|∇h|²⟩."""
    psd: Annotated[Rows, BeforeValidator(read_psd)] | None = None
    """Rows (q in rad/m, C in m⁴): the content of `psd_file`, or the C(q) of the map `topography`; f in 1/m in place of
    q by the convention "frequency"."""
    psd_convention: Literal["persson", "surfacetopography", "frequency", "profile"] | None = None
    """"persson": ⟨h²⟩ = 2π ∫ q C dq; "surfacetopography": C is 4π² larger. "frequency": rows are (f, C), q = 2πf, with
    ⟨h²⟩ = 2π ∫ f C df. "profile": (q, C₁) of lines, m³, with ⟨h²⟩ = 2 ∫ C₁ dq, which a loaded scene has as C(q)."""
    psd_source: Literal["scan"] | None = None
    """"scan": the table was measured on maps, as by `topography`; None: it is as stated, without an error."""
    psd_error: PsdError | None = None
    """Errors of the rows of `psd`, see `roughsim.surface.topography.MeasuredSpectrum`; None: unknown of a scan."""
    psd_scans: tuple[Annotated[str, BeforeValidator(read_title)], ...] | None = None
    """What was read of each scan: its channel and units, in words."""
    psd_texture: PsdTexture | None = None
    """A row for each map, see `roughsim.surface.topography.texture.Texture`; None: unknown of a scan."""
    psd_directions: PsdDirections | None = None
    """Rows (q, M at even angles from 0 on, below π): C(q⃗) = C(q) M(q, φ) of a scan with a lay, φ the angle of q⃗."""
    psd_filled: Annotated[float, Quantity("", "0.1", ge=0, lt=1)] | None = None
    """Share of the scans that was undefined and filled; part of their error."""
    hurst: Hurst | None = None
    """H of the self-affine C(q), see `roughsim.SelfAffineSpectrum`; so are the next four."""
    q_min: QMin | None = None
    q_roll_off: QRollOff | None = None
    q_max: QMax | None = None
    roll_off_exponent: Annotated[float, Quantity("", "1.5", ge=0, le=4)] | None = None
    spectrum: Annotated[Any, BeforeValidator(_read_spectrum)] | None = None
    """The record of a C(q) of its own name and keys, in place of all others."""
    lay: Annotated[float, Quantity("", "3", gt=0), AfterValidator(_check_lay)] | None = None
    """γ, the ratio of lengths along the grooves and across: C is C(q) at (√γ q_along, q_across/√γ). None: isotropic."""
    lay_direction: Annotated[float, _ANGLE] | None = None
    """Of the grooves, from x towards y; None is along x."""

    @property
    def directed(self) -> float | None:
        """The angle of the lay of a scan whose directions are known, radians; None of others."""
        lay = self.psd_texture[0].lay if self.psd_texture else 0.0
        return lay if self.psd_directions else None

    @property
    def rough(self) -> bool:
        """Whether the face has a roughness of its own keys."""
        return True

    @property
    def grooves(self) -> tuple[float, float]:
        """The lay, and the direction of the grooves, 0 ≤ angle < π; (1, 0) of an isotropic face."""
        lay = self.lay or 1.0
        return lay, (self.lay_direction or 0.0) % pi if lay > 1.0 else 0.0

    @classmethod
    def known_keys(cls) -> list[str]:
        """Return the keys that a scene file may give; the files named by two of them are read before."""
        return [*super().known_keys(), "psd_file", "topography", *ScanOptions.known_keys()]

    _fits = model_validator(mode="after")(_check_roughness)


@record("body")
class BodySection(Record):
    """The moving body, whose temperature is reported."""

    youngs_modulus: Annotated[float, Quantity("Pa", '"200 GPa"', gt=0)]
    poisson_ratio: Annotated[float, Quantity("", "0.3", gt=-1, le=0.5)]
    penetration_hardness: (
        Annotated[
            float, Quantity("Pa", '"1.2 GPa"', gt=0), BeforeValidator(_refuse_table_of_hardness)
        ]
        | None
    ) = None
    """σ_P; None is elastic."""
    conductivity: Conductivity
    """κ, or rows (absolute temperature in K, κ), linear between."""
    density: Annotated[float, Quantity("kg/m^3", '"7900 kg/m^3"', gt=0)]
    heat_capacity: Annotated[float, Quantity("J/(kg K)", '"500 J/(kg K)"', gt=0)]
    melting_temperature: Annotated[float, Quantity("K", '"1800 K"', gt=0)] | None = None
    """Absolute. A hotter contact gives a warning; no number depends on it."""
    temperature: Annotated[float, KELVIN] | None = None
    """Absolute, before sliding: in place of `sliding.background_temperature`, where the bodies differ."""
    skin: SkinSection | None = None
    """A layer of another material that the contact touches."""
    heat_depth: HeatDepth | None = None
    """h of the heat released with the density q̇ e^(−z/h)/h; None is the surface."""


@record("counterface")
class CounterfaceSection(optional_keys(BodySection), SurfaceSection):  # type: ignore[misc]
    """The resting body: like the moving one, or its own keys of `SurfaceSection` and `BodySection`.

    Without surface keys it is smooth, without `youngs_modulus` rigid, without `conductivity` insulating.
    """

    like: Literal["body"] | None = None
    """"body": the same material with the same roughness, uncorrelated."""

    @property
    def rough(self) -> bool:
        """Whether the counterface has a roughness of its own keys."""
        return any(getattr(self, key) is not None for key in ROUGHNESS_KEYS)

    _fits = model_validator(mode="after")(_check_counterface)


@record("sliding")
class SlidingSection(Record):
    """Load, friction and speed."""

    nominal_pressure: Annotated[float, Quantity("Pa", '"90 MPa"', gt=0)]
    friction_coefficient: FrictionCoefficient
    """μ, or rows (absolute temperature in K, μ), linear between."""
    junction_growth: Annotated[float, Quantity("", "9", ge=0, le=100)] | None = None
    """Tabor's α: with friction contact yields at σ_P/√(1 + αμ²). None: friction does not change the contact."""
    speed: Annotated[
        tuple[Annotated[float, SPEED], ...], one_or_list(), AfterValidator(_check_speeds)
    ]
    """Sliding speeds; one number is a tuple of one."""
    direction: (
        Annotated[
            tuple[Annotated[float, _ANGLE], ...], one_or_list(), AfterValidator(_check_directions)
        ]
        | None
    ) = None
    """Of sliding over a face with a lay, or a map that is pressed, from x towards y; one number is a tuple of one."""
    heat_partition: Annotated[Annotated[float, _SHARE] | str, BeforeValidator(_read_share)] = "all"
    """Share of the heat into the moving body, or the rule by which it follows from both bodies."""
    duration: Annotated[float, Quantity("s", '"1 ms"', gt=0)] | None = None
    """Time since sliding began; None is steady. With history = "sliding" each speed slides as far as it comes in it."""
    history: Literal["frozen", "sliding"] = "frozen"
    """"frozen": one contact slides on, unchanged. "sliding": also both faces over one another, contact by contact."""
    slid_distance: Annotated[float, Quantity("m", '"4 mm"', gt=0)] | None = None
    """Of history = "sliding", at all speeds; in place of `duration`."""
    contact_radius: Annotated[float, Quantity("m", '"3 mm"', gt=0)] | None = None
    """Of a round nominal contact, which the counterface carries; None warms both bodies as endless planes."""
    track_radius: Annotated[float, Quantity("m", '"25 mm"', gt=0)] | None = None
    """Of the ring on [body] along which a round contact slides; None is straight."""

    @property
    def warms(self) -> bool:
        """Whether the mean temperature of the surface is known: after a time, or steady under a round contact."""
        return self.duration is not None or self.contact_radius is not None

    @property
    def distances(self) -> tuple[float, ...]:
        """Slid distance of history = "sliding" at each speed, m."""
        return tuple(self.slid_distance or speed * (self.duration or 0.0) for speed in self.speed)

    background_temperature: Annotated[float, KELVIN] | None = None
    """Absolute, of both bodies when sliding began; a table κ(T) or μ(T), and [reaction], need it."""


@record("theory")
class TheorySection(Record):
    """Input of the theory alone."""

    gamma: Annotated[float, Quantity("", "0.45", ge=0, le=1)] = 0.45
    """γ of W = P[γ + (1 − γ)P²]."""
