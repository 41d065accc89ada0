"""`theory`: the results of the analytic theory for a scene, as numbers, a table and a figure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import update_wrapper
from pathlib import Path
from typing import Any, Generic, NoReturn, ParamSpec, TypeVar

import numpy as np

from roughsim.comparison.camera import pictured
from roughsim.comparison.tables import (
    asked_of_scene,
    asked_table,
    by_direction,
    calibrated_note,
    theory_dict,
    theory_table,
    theory_values,
)
from roughsim.estimate.levels import FLASH
from roughsim.grid import Array
from roughsim.planning.limits import Plausibility, judge
from roughsim.results.theories import CALIBRATED, joined, theory_columns
from roughsim.scene import Scene, SceneLike, as_scene
from roughsim.show.markup import in_notebook
from roughsim.show.remarks import warn_of
from roughsim.show.table import Number, Table, table_of, with_unit
from roughsim.show.text import marked
from roughsim.table import heads_of

P = ParamSpec("P")
R = TypeVar("R")


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Theory:
    """The theory over the whole spectrum of a scene; arrays over its speeds, temperatures with the share used.

    Attributes
    ----------
    scene : Scene
        The scene.
    speed : ndarray
        Sliding speed, m/s.
    direction : ndarray
        Directions of sliding over faces with a lay, radians from x: then arrays are over direction and speed. Else
        empty.
    flash_temperature : ndarray
        ⟨Tσ⟩/⟨σ⟩ above the background, K.
    calibrated : ndarray
        The same by the calibrated stress spectrum, K; NaN outside its range.
    flash_gradient : ndarray
        T′_flash, K/m.
    flash_laplacian : ndarray
        ∇²T_flash, K/m².
    flash_width : ndarray
        D_flash, m.
    slope_length : ndarray
        d_flash, m.
    heat_partition : ndarray
        Share of the heat that is used.
    contact_fraction : float
        Fraction of the nominal area in contact.
    plastic_fraction : float
        Fraction of the nominal area that yields.
    judged : Plausibility
        Sizes, assumptions and warnings of the scene.
    """

    scene: Scene
    speed: Array
    direction: Array
    flash_temperature: Array
    calibrated: Array
    flash_gradient: Array
    flash_laplacian: Array
    flash_width: Array
    slope_length: Array
    heat_partition: Array
    contact_fraction: float
    plastic_fraction: float
    judged: Plausibility

    def __repr__(self) -> str:
        flash = ", ".join(f"{value:.4g}" for value in self.flash_temperature.ravel())
        speeds = ", ".join(f"{speed:g}" for speed in self.speed)
        about = f"<Theory of {self.scene.title}: T_flash {flash} K at {speeds} m/s>"
        return "\n".join([about, *marked(self.judged.remarks)])

    def __str__(self) -> str:
        return str(self.table())

    def _repr_html_(self) -> str:
        return in_notebook(self.table(), *marked(self.judged.remarks))

    def table(self) -> Table:
        """Return the table that the command line prints."""
        return theory_table(self.scene)

    def summary(self) -> Table:
        """Return T_flash by each theory with its error, the calibrated ones first, the highest speed first."""
        scene, columns = self.scene, theory_columns(self.scene)
        kelvin = {name: column(FLASH) for name, column in reversed(columns.items())}
        found = {name: one for name, one in kelvin.items() if one and not np.isnan(one.mean).all()}
        rows = []
        for k in np.argsort(-np.array(scene.speeds), kind="stable"):
            row = heads_of(scene.cases[k])
            for name, one in found.items():  # the paper's beside one with an error states none
                states = one.budget or len(found) == 1
                error = one.total_error.flat[k] if states else 0.0
                head = with_unit(name.removesuffix("_calibrated"), "K")
                row[head] = Number(one.mean.flat[k], "K", error)
            row[with_unit("D_flash", "m")] = Number(self.flash_width.flat[k], "m")
            rows.append(row | {"share": Number(self.heat_partition.flat[k])})
        areas = f"{self.contact_fraction:.3g} of the area, {self.plastic_fraction:.3g} yields"
        notes = [
            f"T_flash above the background; contact on {areas}.",
            calibrated_note(scene, ("flash_temperature",)),
        ]
        if asked := asked_of_scene(scene):
            notes.append(f"By --all: {', '.join(asked)}.")
        notes[1:1] = pictured(scene, theory_columns(scene))
        return table_of(rows, scene.title, notes)

    def asked(self) -> Table | None:
        """Return reactions and quantiles that the scene asks for, by the calibrated law; None if nothing."""
        law = {CALIBRATED: theory_columns(self.scene)[CALIBRATED]}
        found = joined(law, asked_of_scene(self.scene), self.scene.directions)
        return asked_table(self.scene, found) if found else None

    def to_dict(self) -> dict[str, Any]:
        """Return the theory, sizes of the scene and warnings as JSON values."""
        return theory_dict(self.scene) | self.judged.to_dict()

    def chart(self, path: str | Path | None, *, csv: str | Path | None = None) -> None:
        """Draw C(q) and C_sm(q), g_σ(r), T_flash(v), D_flash(v) and d_flash(v) as .png, .pdf or .svg.

        `path` is the picture, or None. `csv` is a file for the numbers drawn, .csv. ValueError for another ending, or
        a scene at rest.
        """
        theory_chart({self.scene.title: self}, path, csv=csv)


class _Verb(Generic[P, R]):
    """A function whose AttributeError names the package `theory`, which a reader may have wanted."""

    def __init__(self, function: Callable[P, R]):
        update_wrapper(self, function)
        self._function = function

    def __call__(self, *arguments: P.args, **named: P.kwargs) -> R:
        return self._function(*arguments, **named)

    def __getattr__(self, name: str) -> NoReturn:
        raise AttributeError(
            f"roughsim.theory is the function for a scene, and has no {name!r}; the formulas are in the package of this "
            f"name: from theory import {name}"
        )


@_Verb
def theory(scene: SceneLike, *, changes: Mapping[str, Any] | None = None) -> Theory:
    """Return the results of the analytic theory for a scene.

    A `SceneWarning` names each number beyond the model, and each assumption that is easily missed.

    Parameters
    ----------
    scene : Scene, str, path or dict
        As for `load_scene`.
    changes : mapping, optional
        Other values of some keys of the scene, as for `load_scene`.

    Returns
    -------
    Theory
        Arrays over the speeds of the scene; ``str()`` is the table of ``roughsim theory --all``.

    Raises
    ------
    SceneError
        As from `load_scene`.
    """
    loaded = as_scene(scene, changes)
    judged = judge(loaded)
    warn_of(judged.remarks, above=2)  # this function and its `_Verb`
    values = by_direction(loaded, theory_values(loaded)) | {
        "scene": loaded,
        "speed": np.array(loaded.sliding.speed),
        "direction": np.array(loaded.directions),
        "judged": judged,
    }
    return Theory(**{name: values[name] for name in Theory.__dataclass_fields__})


def theory_chart(
    theories: Mapping[str, Theory], path: str | Path | None, *, csv: str | Path | None = None
) -> None:
    """Draw one or several theories, by their labels, into one figure; other arguments as of `Theory.chart`."""
    from roughsim.charts.curves import Entry, curves_chart  # matplotlib is slow to import
    from roughsim.charts.style import Look

    entries = [Entry(label, one.scene) for label, one in theories.items()]
    title = entries[0].scene.title if len(entries) == 1 else ""
    curves_chart(path, entries, title=title, look=Look(csv=csv))
