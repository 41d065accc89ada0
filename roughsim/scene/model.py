"""`Scene`: surfaces, bodies and sliding of one simulation, and the physics that combines the two bodies."""

import math
from dataclasses import asdict, replace
from functools import cached_property
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from pydantic import BeforeValidator, model_validator
from pydantic_core import to_jsonable_python

from roughsim.observables.catalogue import CAMERA, DISTRIBUTION
from roughsim.scene.camera import CameraSection
from roughsim.scene.changes import with_changes
from roughsim.scene.checks import (
    check_background,
    check_camera,
    check_heat_partition,
    check_history,
    check_junction_growth,
    check_lay,
    check_levels,
    check_load,
    check_nominal_contact,
    check_resolution,
    check_rows,
    check_targets,
    check_temperatures,
    missing_second_body,
)
from roughsim.scene.ensemble import EnsembleSection
from roughsim.scene.numerics import SLIDING, NumericsSection
from roughsim.scene.reactions import ObservablesSection, ReactionSection
from roughsim.scene.schema import Record, record
from roughsim.scene.sections import (
    NOT_IDENTITY,
    SAME_ANGLE,
    BodySection,
    CounterfaceSection,
    SlidingSection,
    SurfaceSection,
    TheorySection,
    read_title,
)
from roughsim.scene.slips import slips, steepness
from roughsim.scene.tables import PSD_SCALES, Rows, at_temperature, directions_of, values_of
from roughsim.scene.written import as_content, scene_table, toml_of
from roughsim.show.markup import in_notebook
from roughsim.show.remarks import Remark, most_serious_first
from roughsim.show.text import marked
from roughsim.surface.directions import DirectedSpectrum, with_lays
from roughsim.surface.power_laws import SelfAffineSpectrum, TabulatedSpectrum
from roughsim.surface.spectrum import Face, SumSpectrum, TruncatedSpectrum
from roughsim.surface.topography import Texture

_DIRECTIONS = (0.0, math.pi / 4, math.pi / 2)  # of a face with a lay, if the scene gives none


class Layers(NamedTuple):
    """What lies on a body: a skin, and the depth of the heat."""

    skin: tuple[float, float, float] | None = None  # in the order of `roughsim.Skin`
    heat_depth: float = 0.0  # h, m


class Conduction(NamedTuple):
    """κ, W/(m K), and D = κ/(ρc), m²/s, of the moving body and of the counterface; None if that is insulating."""

    conductivity: float
    diffusivity: float
    counter_conductivity: float | None = None
    counter_diffusivity: float | None = None
    layers: Layers = Layers()
    counter_layers: Layers = Layers()


@record("", repr=False)
class Scene(Record):
    """A simulated system: frozen, in SI, checked when made and by ``dataclasses.replace``.

    Attributes
    ----------
    surface, body, counterface, sliding, observables, reaction, camera, theory, ensemble, numerics
        The sections of the file; `counterface` is None for a rigid, smooth and insulating one. `observables`,
        `reaction` and `camera` are None unless the file has them.
    title : str
        One line for people.

    Raises
    ------
    SceneError
        One line with the key, its value, the limit and advice.
    """

    title: Annotated[str, BeforeValidator(read_title)] = ""
    surface: SurfaceSection
    body: BodySection
    counterface: CounterfaceSection | None = None
    sliding: SlidingSection
    observables: ObservablesSection | None = None
    reaction: ReactionSection | None = None
    camera: CameraSection | None = None
    theory: TheorySection = TheorySection()
    ensemble: EnsembleSection = EnsembleSection()
    numerics: NumericsSection = NumericsSection()

    @model_validator(mode="after")
    def _fits(self) -> Self:
        sliding, missing = self.sliding, missing_second_body(self.counterface)
        check_junction_growth(sliding, [body.penetration_hardness for body in self.bodies])
        check_load(sliding, self.body, self.penetration_hardness)
        check_heat_partition(sliding, missing)
        check_nominal_contact(sliding)
        kelvin = {name: body.temperature for name, body in self.sections_of_bodies.items()}
        check_temperatures(sliding, kelvin, missing, list(self.tables))
        own = self.body.temperature is not None
        check_background(
            self.background_temperature,
            "body.temperature" if own else "sliding.background_temperature",
            list(self.tables),
            self.temperature_range,
            self._needs_background,
        )
        check_targets(self.ensemble, self.asks)
        check_camera(self.camera, sliding, self.lay)
        check_history(sliding, missing, self.numerics.solver)
        check_rows(self.surface, self.counterface)
        lengths = self.numerics.lengths if self.lay > 1.0 else None
        check_lay(self.sections_of_rough_faces, sliding, list(self.tables), lengths)
        check_levels(self.numerics.levels or (), self.faces, sliding.history, self.elastic)
        _check_derived(self)
        if self.camera is not None:
            check_resolution(self.camera, 2 * math.pi / float(self.spectrum.breaks[0]))
        return self

    @cached_property  # .2 ms, a hundred times in a comparison
    def spectrum(self) -> Face | SumSpectrum:
        """Composite C(q) = C₁(q) + C₂(q) of the two uncorrelated faces, m⁴, Persson's convention."""
        faces = self.faces
        if len(faces) == 1:
            return faces[0]
        return faces[0].scaled(2.0) if faces[0] is faces[1] else faces[0] + faces[1]

    @property
    def rms_slope(self) -> float:
        """√⟨|∇h|²⟩ of the faces together, with their lay."""
        return self.spectrum.rms_slope * steeper(self.lay)

    @cached_property  # asked for with each spectrum, and by two faces that slide
    def faces(self) -> tuple[Face, ...]:
        """C(q) of each rough face, m⁴: one or two."""
        directed = self.directed_angle is not None
        face, other = _face_spectrum(self.surface, directed), self.counterface
        if other is None or not (other.like or other.rough):
            return (face,)
        return (face, face if other.like else _face_spectrum(other, directed))

    @property
    def sliding_faces(self) -> tuple[Face, Face | None]:
        """C(q), m⁴, of the resting and of the moving face, None for a flat.

        The only rough face of a scene rests. Of two, the face of [surface] moves with [body].
        """
        return (self.faces[0], None) if len(self.faces) == 1 else (self.faces[1], self.faces[0])

    @property
    def effective_modulus(self) -> float:
        """E* of 1/E* = Σ (1 − ν²)/E over both bodies, Pa; a rigid one adds nothing."""
        elastic = (body for body in self.bodies if body.youngs_modulus is not None)
        return 1.0 / sum((1.0 - body.poisson_ratio**2) / body.youngs_modulus for body in elastic)

    @property
    def penetration_hardness(self) -> float:
        """Pressure at which contact yields, Pa: σ_P of the softer body, inf if both are elastic.

        With `junction_growth` it is σ_P/√(1 + αμ²): pressure and friction yield together (Tabor 1959).
        """
        hardness = (body.penetration_hardness for body in self.bodies)
        softer = min((limit for limit in hardness if limit is not None), default=math.inf)
        growth = self.sliding.junction_growth
        return (
            softer
            if growth is None
            else softer / math.sqrt(1.0 + growth * self.friction_coefficient() ** 2)
        )

    @property
    def elastic(self) -> bool:
        """Whether no body has a hardness."""
        return math.isinf(self.penetration_hardness)

    @property
    def distribution(self) -> bool:
        """Whether members store the distribution of the temperature over the contact."""
        asked = self.observables
        return self.reaction is not None or (
            asked is not None and (asked.temperature_distribution or asked.heat_above is not None)
        )

    @property
    def asks(self) -> frozenset[str]:
        """What members measure only on request: "distribution" of the temperature, or "camera"."""
        wanted = {DISTRIBUTION: self.distribution, CAMERA: self.camera is not None}
        return frozenset(name for name, asked in wanted.items() if asked)

    @property
    def background_temperature(self) -> float | None:
        """Temperature of the moving body before sliding, absolute, K; None if the scene gives none."""
        own = self.body.temperature
        return self.sliding.background_temperature if own is None else own

    @property
    def temperature_difference(self) -> float:
        """How much hotter the counterface was than the moving body before sliding, K."""
        other = None if self.counterface is None else self.counterface.temperature
        return (
            0.0 if other is None or self.body.temperature is None else other - self.body.temperature
        )

    @property
    def _needs_background(self) -> str:
        """The section or key that needs an absolute temperature; empty without one."""
        if self.reaction is not None:
            return "[reaction]"
        hot = self.observables is not None and self.observables.heat_above is not None
        return "observables.heat_above" if hot else ""

    @property
    def scanned(self) -> bool:
        """Whether a C(q) was measured on maps, and has an error of its own."""
        return bool(self.scanned_faces)

    @property
    def scanned_faces(self) -> dict[str, SurfaceSection]:
        """The sections of faces whose C(q) was measured on maps, by their names."""
        faces = self.sections_of_faces.items()
        return {name: face for name, face in faces if face.psd_source == "scan"}

    @property
    def sections_of_bodies(self) -> dict[str, BodySection | CounterfaceSection]:
        """The sections that may have a material, by their names."""
        counterface = {"counterface": self.counterface} if self.counterface is not None else {}
        return {"body": self.body, **counterface}

    @property
    def grooves(self) -> tuple[float, float]:
        """The lay of the rough faces, and the direction of its grooves, radians from x; (1, 0) of isotropic ones.

        It is (1, 0) as well of faces whose lays differ: these have square pixels.
        """
        return (1.0, 0.0) if self.lays_differ else self.surface.grooves

    @cached_property  # asked for a hundred times in each table of a run
    def lays_differ(self) -> bool:
        """Whether the rough faces have two lays, or only one of them has one."""
        first, *others = (face.grooves for face in self.sections_of_rough_faces.values())
        return any(
            lay != first[0] or abs(math.remainder(angle - first[1], math.pi)) > SAME_ANGLE
            for lay, angle in others
        )

    @property
    def lay(self) -> float:
        """γ, the ratio of lengths along the grooves and across; 1 is isotropic."""
        return self.grooves[0]

    @cached_property  # as this
    def directions(self) -> tuple[float, ...]:
        """Directions of sliding with results of their own, radians from x; none of isotropic faces."""
        lay = self.directed_angle
        if lay is None and self.lay == 1.0:
            return ()
        return self.sliding.direction or tuple((lay or 0.0) + turn for turn in _DIRECTIONS)

    @property
    def directed_angle(self) -> float | None:
        """The angle from which directions of surfaces drawn by C(q⃗) count, radians; None if they are not so drawn.

        It is that of the lay of a scan, 0 of faces whose lays differ. Where contact slides, or with tables over
        temperature, surfaces are isotropic.
        """
        if self.sliding.history == SLIDING or self.tables:
            return None
        angles = (face.directed for face in self.sections_of_rough_faces.values())
        none = 0.0 if self.lays_differ else None
        return next((angle for angle in angles if angle is not None), none)

    @property
    def first_direction(self) -> dict[str, float]:
        """The label of the first direction with results of its own, for `Estimate.sel`; none of isotropic faces."""
        return {"direction": self.directions[0]} if self.directions else {}

    def towards(self, direction: float) -> Self:
        """Return the scene with one direction of sliding, radians from x."""
        return replace(self, sliding=replace(self.sliding, direction=(direction,)))

    @property
    def headings(self) -> tuple[float, ...] | None:
        """The direction of each entry of `speeds`, radians from the grooves; None of isotropic faces."""
        start, each = self.grooves[1], len(self.sliding.speed)
        turned = (math.remainder(angle - start, math.tau) for angle in self.directions)
        return tuple(angle for angle in turned for _ in range(each)) or None

    @property
    def lay_along_slide(self) -> float:
        """The lay of faces that slide along their grooves, 1/γ if across: by it the slide stretches their cell."""
        across = abs(math.sin((self.headings or (0.0,))[0])) > 0.5
        return 1.0 / self.lay if across else self.lay

    @property
    def sections_of_rough_faces(self) -> dict[str, SurfaceSection]:
        """The sections with a roughness of their own, by their names."""
        faces = self.sections_of_faces.items()
        return {name: face for name, face in faces if face.rough}

    @property
    def sections_of_faces(self) -> dict[str, SurfaceSection]:
        """The sections that may have a roughness, by their names."""
        counterface = {"counterface": self.counterface} if self.counterface is not None else {}
        return {"surface": self.surface, **counterface}

    @property
    def textures(self) -> dict[str, tuple[Texture, ...]]:
        """The textures of the maps of each face by its section; no entry for a C(q) without maps."""
        faces = self.sections_of_faces.items()
        return {name: face.psd_texture for name, face in faces if face.psd_texture}

    @property
    def melting_temperature(self) -> float:
        """The lower melting temperature of the bodies, absolute, K; inf if none is given."""
        temperatures = (body.melting_temperature for body in self.bodies)
        return min((kelvin for kelvin in temperatures if kelvin is not None), default=math.inf)

    @property
    def counterface_conducts(self) -> bool:
        """Whether a second body conducts heat."""
        return len(self.bodies) == 2 and self.bodies[1].conductivity is not None

    @property
    def tables(self) -> dict[str, list[Rows]]:
        """Tables over the absolute temperature by their keys; no entry if all of a key are numbers."""
        keys = {
            "conductivity": [body.conductivity for body in self.bodies],
            "friction_coefficient": [self.sliding.friction_coefficient],
        }
        tables = {
            key: [value for value in values if isinstance(value, tuple)]
            for key, values in keys.items()
        }
        return {key: rows for key, rows in tables.items() if rows}

    @property
    def temperature_range(self) -> tuple[float, float]:
        """Range of absolute temperatures common to all tables, K: (0, inf) without tables."""
        tables = [rows for several in self.tables.values() for rows in several]
        low, high = ([rows[end][0] for rows in tables] for end in (0, -1))
        return max(low, default=0.0), min(high, default=math.inf)

    def friction_coefficient(self, temperature: float | None = None) -> float:
        """Return μ at an absolute `temperature`, K; SceneError if it is not within a table of μ, or missing then."""
        return at_temperature(self.sliding.friction_coefficient, temperature)

    def conduction(self, temperature: float | None = None) -> Conduction:
        """Return κ and D of both bodies at an absolute `temperature`, K; SceneError as `friction_coefficient`."""
        bodies = (body for body in self.bodies if body.conductivity is not None)
        numbers = [number for body in bodies for number in _conduction_of(body, temperature)]
        return Conduction(*numbers, layers=self.layers[0], counter_layers=self.layers[1])  # type: ignore[misc, arg-type]

    @property
    def layers(self) -> tuple[Layers, Layers]:
        """What lies on the moving body and on the counterface."""
        several = [_layers_of(body) for body in self.bodies]
        return several[0], several[-1] if len(several) == 2 else Layers()

    @property
    def speeds(self) -> tuple[float, ...]:
        """Speed of each result, m/s: all speeds in the first of the `directions`, then all in the next."""
        return self.sliding.speed * max(len(self.directions), 1)

    @property
    def cases(self) -> list[dict[str, float]]:
        """The labels of each entry of `speeds`: its "speed", m/s, and of faces with a lay its "direction", radians."""
        each = [{"speed": speed} for speed in self.sliding.speed]
        turned = [{"direction": angle, **one} for angle in self.directions for one in each]
        return turned or each

    @property
    def bodies(self) -> tuple[BodySection | CounterfaceSection, ...]:
        """The moving body, and the resting one if the scene has it."""
        if self.counterface is None:
            return (self.body,)
        return self.body, self.body if self.counterface.like else self.counterface

    def identity(self) -> dict[str, Any]:
        """Return the identity of this scene: physics, numerics and seed, as dotted key → JSON value.

        Keys that change no number of a member are left out: texts (title); `ensemble.realizations`,
        `ensemble.max_realizations`, `ensemble.until` and `numerics.keep_fields`; errors and sources of a C(q), and the
        melting temperature; a background temperature without a table κ(T) or μ(T); [observables] and [reaction] but for
        the distribution of the temperature, which members store if there is either. Keys without a value are absent,
        but two have a number then: `q_roll_off` is `q_min`, and `roll_off_exponent` is 0.
        """
        sections = to_jsonable_python(self, exclude_none=True)
        flat = {
            f"{name}.{key}": value
            for name, section in sections.items()
            if name not in ("title", "observables", "reaction")
            for key, value in section.items()
        }
        for face in ("surface", "counterface"):
            if f"{face}.q_min" in flat:
                flat.setdefault(f"{face}.q_roll_off", flat[f"{face}.q_min"])
                flat.setdefault(f"{face}.roll_off_exponent", 0.0)
        left_out = {*NOT_IDENTITY}
        if self.sliding.history == "frozen":
            left_out.add("sliding.history")  # older runs do not have the key
        if not self.tables:
            left_out |= {"body.temperature", "counterface.temperature"}
            left_out.add("sliding.background_temperature")
        if self.sliding.direction is not None and len(self.sliding.direction) == 1:
            (flat["sliding.direction"],) = self.sliding.direction  # as older runs have it
        if self.distribution:
            flat["observables.temperature_distribution"] = True
        return {key: value for key, value in flat.items() if key not in left_out}

    def with_(self, key: str, value: Any) -> Self:
        """Return the scene with another value of a key, such as "sliding.nominal_pressure"; checked as in a file.

        A value is a number in SI or a text with a unit; None takes the key away.
        """
        return type(self)(**with_changes(self.content(), {key: value}))

    @property
    def slips(self) -> list[Remark]:
        """Warnings of numbers that are probably mistakes."""
        bodies = self.sections_of_bodies
        return list(slips(self.spectrum, self.scanned, bodies, self.sliding))

    @property
    def remarks(self) -> list[Remark]:
        """Warnings of steep slopes and of numbers that are probably mistakes; `plan` and `theory` have more."""
        return most_serious_first([*steepness(self.rms_slope), *self.slips])

    def __repr__(self) -> str:
        return "\n".join([f"<Scene {self.title or 'untitled'}>", *marked(self.remarks)])

    def __str__(self) -> str:
        return "\n".join([str(scene_table(self.content())), *marked(self.remarks)])

    def _repr_html_(self) -> str:
        return in_notebook(scene_table(self.content()), *marked(self.remarks))

    def content(self) -> dict[str, Any]:
        """Return the sections by their names, as a scene file has them: SI, without keys that have no value."""
        return as_content(asdict(self))

    def to_toml(self) -> str:
        """Return a scene file that `load_scene` reads back to an equal scene: SI, units as comments, tables inline."""
        return toml_of(self.content())


def _conduction_of(
    body: BodySection | CounterfaceSection, temperature: float | None
) -> tuple[float, float]:
    """Return κ, W/(m K), and D, m²/s, of a body that conducts."""
    kappa = at_temperature(body.conductivity, temperature)
    return kappa, kappa / (body.density * body.heat_capacity)


def _layers_of(body: BodySection | CounterfaceSection) -> Layers:
    """Return the skin and the depth of the heat of a body; nothing lies on one that takes no heat."""
    skin = None if body.skin is None else body.skin.layer(body.density, body.heat_capacity)
    return Layers(skin, body.heat_depth or 0.0)


def _face_spectrum(face: SurfaceSection | CounterfaceSection, directed: bool) -> Face:
    """Return C(q) of one face, m⁴, with the directions of its scan or of its lay if `directed`."""
    spectrum, (lay, angle) = _isotropic_spectrum(face), face.grooves
    if directed and face.psd_directions is not None:
        return DirectedSpectrum(spectrum, directions_of(face.psd_directions))
    return with_lays([(spectrum, lay, angle)]) if directed and lay > 1.0 else spectrum


def _isotropic_spectrum(face: SurfaceSection | CounterfaceSection) -> Face:
    """Return C(q) of one face, m⁴, in Persson's convention, before its lay stretches it."""
    if face.spectrum is not None:
        return TruncatedSpectrum(face.spectrum)
    if face.psd is not None:
        q, psd = np.array(face.psd).T
        per_row, factor = PSD_SCALES[face.psd_convention or ""]
        return TabulatedSpectrum(per_row * q, factor * psd)
    shape: dict[str, Any] = {
        key: getattr(face, key) for key in ("hurst", "q_min", "q_max", "q_roll_off")
    }
    shape["roll_off_exponent"] = face.roll_off_exponent or 0.0
    if face.rms_height is not None:
        return SelfAffineSpectrum.from_rms_height(face.rms_height, **shape)
    slope = (face.rms_slope or 0.0) / steeper(face.lay or 1.0)
    return SelfAffineSpectrum.from_rms_slope(slope, **shape)


def steeper(lay: float) -> float:
    """Return the rms slope of a surface with a lay over that of the isotropic one that it stretches."""
    return math.sqrt((lay + 1.0 / lay) / 2.0)


def _check_derived(scene: Scene) -> None:
    """Refuse numbers whose roughness, modulus, or diffusivity at some temperature overflows or vanishes."""
    try:
        derived = [
            ("rms height", scene.spectrum.rms_height, "m"),
            ("rms slope", scene.rms_slope, ""),
            ("effective modulus", scene.effective_modulus, "Pa"),
        ]
        for name, body in zip(
            ("diffusivity", "diffusivity of the counterface"), scene.bodies, strict=False
        ):
            derived += [
                (name, kappa / (body.density * body.heat_capacity), "m²/s")
                for kappa in values_of(body.conductivity)
            ]
    except (ArithmeticError, ValueError) as error:
        raise ValueError(
            f"surface or body: numbers beyond the range of floats ({error}); check them"
        ) from None
    for name, value, unit in derived:
        if not 0.0 < value < math.inf:
            raise ValueError(
                f"surface or body: the {name} becomes {value:.6g} {unit}; check the numbers it is made of"
            )
