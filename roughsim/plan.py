"""From a scene to its numerics: the cheapest grids and tolerances that meet the asked-for error, each with its reason.

The rules, measured on steel: what yields plastically needs no resolution of its own, so the yield wavenumber q_y sets
the scale, not q_max. Bandwidth, not pixels, is the error of capped contact, so it is solved up to two cut-offs and
extrapolated; contact on the smoothed spectrum C_sm converges by itself.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from math import ceil, inf, isfinite, pi
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

from roughsim import analytic
from roughsim.errors import ResolutionError, number, positive
from roughsim.grid import Grid

if TYPE_CHECKING:
    from roughsim.scene import Scene
    from roughsim.scene.sections import CounterfaceSection, SurfaceSection

Column = Literal["smoothed", "capped", "elastic"]
ELASTIC_LIMIT = 2048  # points per side up to which an elastic scene is resolved; beyond, C(q) is cut
CAPPED_LIMIT = 4096
BYTES_PER_POINT = 120  # peak memory of a solve, measured
SECONDS_PER_POINT = 4.0e-7  # time of one realization per grid point, one thread, within a factor of two


class Reason(NamedTuple):
    """One choice of the plan: what was chosen, and why."""

    choice: str
    value: str
    reason: str


@dataclass(frozen=True, slots=True)
class Level:
    """One contact problem of each realization.

    Parameters
    ----------
    column : {"smoothed", "capped", "elastic"}
        Elastic contact on C_sm, capped contact on C, or elastic contact on C.
    shape : (int, int)
        Points along x and y.
    q_max : float
        Where the spectrum is cut, rad/m, at most the Nyquist wavenumber.
    """

    column: Column
    shape: tuple[int, int]
    q_max: float

    def __post_init__(self) -> None:
        if self.column not in get_args(Column):
            raise ValueError(f"column = {self.column!r} must be one of {', '.join(get_args(Column))}")
        object.__setattr__(self, "shape", Grid(self.shape, (1.0, 1.0)).shape)
        positive("q_max", self.q_max, "rad/m")


@dataclass(frozen=True, slots=True)
class Numerics:
    """How well a scene is computed. Levels with the same `column` are paired and extrapolated in q_max.

    Parameters
    ----------
    levels : tuple of Level
        Contact problems of each realization; the position is the level number.
    lengths : (float, float)
        Sides of the periodic cell, m.
    tolerance : float
        Relative pressure error aimed at in the contact solve.
    precision : {"double", "single"}
        Of the pressure fields.
    slid_distance : float or None
        Distance slid from rest in temperature fields, m; None is half the cell. Moments are steady.
    threads : int
        Threads of each realization.
    keep_fields : int
        Number of realizations, from the first, whose fields are stored.
    reasons : tuple of Reason
        Why the plan chose so; not part of what the numerics are.
    """

    levels: tuple[Level, ...]
    lengths: tuple[float, float]
    tolerance: float = 1e-4
    precision: Literal["double", "single"] = "double"
    slid_distance: float | None = None
    threads: int = 1
    keep_fields: int = 1
    reasons: tuple[Reason, ...] = field(default=(), compare=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "levels", tuple(self.levels))
        if not self.levels:
            raise ValueError("levels is empty; at least one level is needed")
        for level in self.levels:
            grid = Grid(level.shape, self.lengths)
            if level.q_max > grid.nyquist * (1 + 1e-12):
                raise ResolutionError(
                    f"q_max = {level.q_max:.4g} rad/m exceeds the Nyquist wavenumber {grid.nyquist:.4g} rad/m of the "
                    f"grid {level.shape}; refine the grid or lower q_max"
                )
        object.__setattr__(self, "lengths", grid.lengths)
        if not 0.0 < number("tolerance", self.tolerance) < 1.0:
            raise ValueError(f"tolerance = {self.tolerance:.6g} must lie between 0 and 1")
        if self.precision not in ("double", "single"):
            raise ValueError(f'precision = {self.precision!r} must be "double" or "single"')
        _check_counts(self.threads, self.keep_fields)

    def grid(self, level: int) -> Grid:
        """Return the grid of a level."""
        return Grid(self.levels[level].shape, self.lengths)

    def of_column(self, column: str) -> tuple[int, ...]:
        """Return the levels of a column, finest last."""
        numbers = [i for i, level in enumerate(self.levels) if level.column == column]
        return tuple(sorted(numbers, key=lambda i: self.levels[i].q_max))

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns that are computed, in the order smoothed, capped, elastic."""
        return tuple(column for column in get_args(Column) if self.of_column(column))

    @property
    def stream(self) -> int:
        """The level whose random stream all levels share: the finest. Paired levels see the same modes."""
        return max(range(len(self.levels)), key=lambda i: (self.levels[i].q_max, self.levels[i].shape))

    def to_dict(self) -> dict[str, Any]:
        """Return what these numerics are as JSON values, without the reasons and what does not change a number."""
        levels = [{"column": a.column, "shape": list(a.shape), "q_max": a.q_max} for a in self.levels]
        return {
            "levels": levels,
            "lengths": list(self.lengths),
            "tolerance": self.tolerance,
            "precision": self.precision,
            "slid_distance": None if self.slid_distance is None else repr(float(self.slid_distance)),
            "threads": self.threads,
            "keep_fields": self.keep_fields,
        }

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> Numerics:
        """Return the numerics that `to_dict` described."""
        levels = tuple(Level(a["column"], tuple(a["shape"]), a["q_max"]) for a in values["levels"])
        distance = values["slid_distance"]
        return cls(
            levels,
            tuple(values["lengths"]),
            values["tolerance"],
            values["precision"],
            None if distance is None else float(distance),
            values["threads"],
            values["keep_fields"],
        )


def _check_counts(threads: Any, keep_fields: Any) -> None:
    if isinstance(threads, bool) or int(threads) != threads or threads < 1:
        raise ValueError(f"threads = {threads!r} must be a whole number ≥ 1")
    if isinstance(keep_fields, bool) or int(keep_fields) != keep_fields or keep_fields < 0:
        raise ValueError(f"keep_fields = {keep_fields!r} must be a whole number ≥ 0")


def plan(scene: Scene, target_error: float | None = None) -> Numerics:
    """Choose the numerics of a scene by rule; keys of its [numerics] section are taken as they are.

    Parameters
    ----------
    scene : Scene
        What is to be computed.
    target_error : float, optional
        Relative error aimed at in T_flash; left out: what the scene's `until` asks of it, or 1 %.

    Returns
    -------
    Numerics
        With `reasons`, one for each choice.

    Raises
    ------
    ValueError
        If `target_error` is not in (0, 1).
    ResolutionError
        If the machine has too little memory for what is asked.
    """
    if target_error is None:
        target_error = dict(scene.ensemble.until).get("flash_temperature", 0.01)
    if not 0.0 < number("target_error", target_error) < 1.0:
        raise ValueError(f"target_error = {target_error:.6g} must lie between 0 and 1")
    given = scene.numerics
    lengths, reasons = _lengths(scene)
    if given.levels is not None:
        levels = tuple(Level(level.column, level.shape, level.q_max) for level in given.levels)
        reasons.append(Reason("levels", _listed(levels), "given in the scene"))
    else:
        chosen = _elastic_levels(scene, lengths) if scene.elastic else _capped_levels(scene, lengths, target_error)
        levels = tuple(level for level, _ in chosen)
        reasons += [reason for _, reason in chosen]
    numerics = _overridden(Numerics(levels, lengths), scene, reasons)
    _check_columns(scene, numerics)
    return replace(numerics, reasons=(*reasons, *_costs(numerics)))


def _lengths(scene: Scene) -> tuple[tuple[float, float], list[Reason]]:
    if scene.numerics.lengths is not None:
        return scene.numerics.lengths, [Reason("cell", _mm(scene.numerics.lengths), "given in the scene")]
    spectrum = scene.spectrum
    longest = 2 * pi / spectrum.breaks[0]
    length, reason = 4 * longest, "4 longest waves (2π/q_min) per side; more change T_flash by less than its error"
    plateau = _plateau_end(scene)
    if plateau is not None:
        wave = 2 * pi / plateau
        length = max(8 * wave, min(4 * longest, 16 * wave))
        reason = f"{length / wave:.3g} roll-off waves (2π/q_roll_off) per side: C(q) is flat below q_roll_off"
    return (length, length), [Reason("cell", _mm((length, length)), reason)]


def _plateau_end(scene: Scene) -> float | None:
    """q_roll_off where every rough face is flat (m < 1) below it, else None."""
    faces: list[SurfaceSection | CounterfaceSection] = [scene.surface]
    if scene.counterface is not None and scene.counterface.rough:
        faces.append(scene.counterface)
    ends = []
    for face in faces:
        kink, flat = face.q_roll_off, (face.roll_off_exponent or 0.0) < 1.0
        if kink is None or face.q_min is None or kink <= face.q_min or not flat:
            return None
        ends.append(kink)
    return min(ends)


def _elastic_levels(scene: Scene, lengths: tuple[float, float]) -> list[tuple[Level, Reason]]:
    q_max = scene.spectrum.breaks[-1]
    limit = ELASTIC_LIMIT * 2 * pi / (8 * max(lengths))
    reason = "8 pixels per shortest wave"
    if q_max > limit:
        reason += f"; C(q) cut at q_c = {limit:.3g} rad/m (q_max = {q_max:.3g}): theory is summed over the same modes"
    return [_level("elastic", min(q_max, limit), 8, lengths, reason)]


def _capped_levels(scene: Scene, lengths: tuple[float, float], target_error: float) -> list[tuple[Level, Reason]]:
    q_max = scene.spectrum.breaks[-1]
    q_yield = analytic.yield_wavenumber(scene)
    where = f"q_y = {q_yield:.3g} rad/m, where 99 % of the contact has yielded"
    if not isfinite(q_yield):
        q_yield, where = q_max, f"q_max = {q_max:.3g} rad/m: 99 % yielding is not reached"
    smooth = min(1.5 * q_yield, q_max)
    chosen = [_level("smoothed", smooth, 8, lengths, f"1.5 × {where}; 8 pixels per shortest wave: converged")]
    finest = 16 if target_error <= 0.02 else 8
    limit = CAPPED_LIMIT * 2 * pi / (4 * max(lengths))
    top = min(finest * q_yield, q_max, limit)
    if top < q_max:
        chosen.append(_level("capped", top / 2, 4, lengths, "half of the finest q_c, to extrapolate as 1/q_c"))
    reason = f"{top / q_yield:.3g} q_y at 4 pixels per shortest wave"
    if top == limit:
        reason += f"; cut by the limit of {CAPPED_LIMIT} points per side"
    return [*chosen, _level("capped", top, 4, lengths, reason)]


def _level(
    column: Column, q_max: float, pixels: int, lengths: tuple[float, float], reason: str
) -> tuple[Level, Reason]:
    shape = fast_size(pixels * q_max * lengths[0] / (2 * pi)), fast_size(pixels * q_max * lengths[1] / (2 * pi))
    level = Level(column, shape, q_max)
    return level, Reason(column, _listed((level,)), reason)


def fast_size(points: float) -> int:
    """Return the next size of the form 2^a·{4, 5, 6} ≥ `points` less 2 %: fast to transform, easy to halve."""
    wanted = max(8, ceil(0.98 * points))
    power = 1
    while 8 * power < wanted:
        power *= 2
    return min(k * power for k in (4, 5, 6, 8) if k * power >= wanted)


def _overridden(numerics: Numerics, scene: Scene, reasons: list[Reason]) -> Numerics:
    """Apply what the scene's [numerics] fixes, and say why the rest is what it is."""
    why = {
        "tolerance": "below every other error",
        "precision": "double costs little beside the solve's own transforms",
        "slid_distance": "half the cell: a longer slide would meet its own periodic hot track (fields only)",
        "threads": "one per realization: realizations run side by side",
        "keep_fields": "enough to look at; every further one costs disk space",
    }
    given = {key: getattr(scene.numerics, key) for key in why if getattr(scene.numerics, key) is not None}
    numerics = replace(numerics, **given)
    for key, reason in why.items():
        value = getattr(numerics, key)
        shown = "L/2" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
        reasons.append(Reason(key, shown, "given in the scene" if key in given else reason))
    reasons.append(
        Reason(
            "moments", "all speeds at once", "averaged over all sliding directions in closed form; C(q) is isotropic"
        )
    )
    return numerics


def _check_columns(scene: Scene, numerics: Numerics) -> None:
    allowed = ("elastic",) if scene.elastic else ("smoothed", "capped")
    for level in numerics.levels:
        if level.column not in allowed:
            kind = "elastic" if scene.elastic else "capped"
            raise ValueError(f'column = "{level.column}" does not fit {kind} scene; use {" or ".join(allowed)}')


def _costs(numerics: Numerics) -> list[Reason]:
    points = [level.shape[0] * level.shape[1] for level in numerics.levels]
    memory, available = BYTES_PER_POINT * max(points), _memory()
    if memory > 0.8 * available:
        raise ResolutionError(
            f"memory = {memory / 1e9:.3g} GB for a grid of {max(points)} points exceeds 80 % of the machine's "
            f"{available / 1e9:.3g} GB; lower the levels' shape"
        )
    seconds = SECONDS_PER_POINT * sum(points)
    return [
        Reason("memory", f"{memory / 1e9:.2g} GB per worker", "largest grid"),
        Reason("time", f"about {seconds:.2g} s per realization", "one thread, within a factor of two"),
    ]


def _memory() -> float:
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (ValueError, OSError, AttributeError):
        return inf  # unknown on this system


def _listed(levels: tuple[Level, ...]) -> str:
    return ", ".join(f"{a.column} {a.shape[0]} × {a.shape[1]} to q_c = {a.q_max:.3g} rad/m" for a in levels)


def _mm(lengths: tuple[float, float]) -> str:
    return f"{lengths[0] * 1e3:.4g} mm × {lengths[1] * 1e3:.4g} mm"


__all__ = ["Column", "Level", "Numerics", "Reason", "fast_size", "plan"]
