"""`Scene`: the sections of one simulation, checked against each other, and its texts."""

from dataclasses import asdict, replace
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, model_validator
from pydantic_core import to_jsonable_python

from roughsim.observables.catalogue import CAMERA, DISTRIBUTION
from roughsim.scene.camera import CameraSection
from roughsim.scene.changes import with_changes
from roughsim.scene.checks import (
    check_background,
    check_camera,
    check_derived,
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
)
from roughsim.scene.ensemble import EnsembleSection
from roughsim.scene.faces import Faces
from roughsim.scene.numerics import NumericsSection
from roughsim.scene.reactions import ObservablesSection, ReactionSection
from roughsim.scene.schema import Record, record
from roughsim.scene.sections import (
    NOT_IDENTITY,
    BodySection,
    CounterfaceSection,
    SlidingSection,
    SurfaceSection,
    TheorySection,
    read_title,
)
from roughsim.scene.slips import slips, steepness
from roughsim.scene.written import as_content, scene_table, toml_of
from roughsim.show.markup import in_notebook
from roughsim.show.remarks import Remark, most_serious_first
from roughsim.show.text import marked


@record("", repr=False)
class Scene(Faces, Record):
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
        check_junction_growth(self)
        check_load(self)
        check_heat_partition(self)
        check_nominal_contact(self.sliding)
        check_temperatures(self)
        check_background(self, self._needs_background)
        check_targets(self.ensemble, self.asks)
        check_camera(self, self.camera)
        check_history(self, self.numerics.solver)
        check_rows(self)
        check_lay(self, self.numerics.lengths)
        check_levels(self, self.numerics.levels or ())
        check_derived(self)
        check_resolution(self, self.camera)
        return self

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
    def _needs_background(self) -> str:
        """The section or key that needs an absolute temperature; empty without one."""
        if self.reaction is not None:
            return "[reaction]"
        hot = self.observables is not None and self.observables.heat_above is not None
        return "observables.heat_above" if hot else ""

    def towards(self, direction: float) -> Self:
        """Return the scene with one direction of sliding, radians from x."""
        return replace(self, sliding=replace(self.sliding, direction=(direction,)))

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
        return list(slips(self))

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
