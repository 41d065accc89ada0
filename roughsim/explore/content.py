"""The content of the page, computed without Bokeh: the run as it grows, and the fields of a member."""

from dataclasses import dataclass
from math import ceil, cos, floor, isinf, log, log10, sin
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.charts.reaction import Lines, reaction_lines
from roughsim.comparison.tables import budget_table
from roughsim.ensemble.status import state_line
from roughsim.estimate.errors import half_width, spread_of
from roughsim.estimate.telescoping import correlation_of
from roughsim.grid import Grid
from roughsim.heat.statistics import ContactTemperature, contact_temperature
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.planning.realization import realize
from roughsim.results.folder import gap, open_run
from roughsim.results.run import Run
from roughsim.results.snapshots import pictured
from roughsim.scene import Scene, with_short_tables
from roughsim.show.table import table_text
from roughsim.show.text import PIPED
from roughsim.table import Estimate

CORRELATION = "pressure_correlation"
OVER_SPEED = ("flash_temperature", "flash_width", "slope_length")
Field = NDArray[Any]
Ends = tuple[float, float]
PREVIEW = 1024  # points per side that the temperature is computed on while the slider moves
PIXELS = 512  # per side of an image: more cannot be seen, and an image is sent at every move of the slider


class Summary(NamedTuple):
    """A run at one moment: problems, error budget and curves by column, sound and kept realizations by level.

    A curve is over distance, m, or over speed, m/s, in each direction if there are any; the error of g_σ is the
    statistical one. `with_snapshots` are the realizations with snapshots of both faces, `reactions` the lines of what a
    reaction feels, by panel, in each direction.
    """

    problems: list[str]
    budget: dict[str, str]
    measured: dict[str, dict[str, Estimate]]
    sound: dict[int, list[int]]
    kept: dict[int, list[int]]
    with_snapshots: list[int]
    reactions: dict[float | None, dict[str, Lines]]


class WatchedRun:
    """A run that may be empty or growing; damaged files are named and left out. RecordError if the folder is no run."""

    def __init__(self, folder: str | Path):
        self.run: Run = open_run(folder, damaged="skip")
        self._theory: dict[float | None, dict[str, tuple[Field, Field, Field]]] = {}
        self.theory(next(iter(self.run.scene.directions), None))  # before the page opens
        self._lock = Lock()
        nothing: dict[int, list[int]] = {level: [] for level in self.run.numerics.single}
        self._latest: tuple[Any, Summary] = None, Summary([], {}, {}, nothing, nothing, [], {})

    def theory(self, direction: float | None) -> dict[str, tuple[Field, Field, Field]]:
        """Return `theory_curves`, which are computed once in each direction."""
        if direction not in self._theory:
            self._theory[direction] = theory_curves(self.run, direction)
        return self._theory[direction]

    @property
    def deleted(self) -> bool:
        """Whether the folder was deleted or moved."""
        return not (self.run.folder / "run.json").exists()

    def state(self) -> str:
        """Return the number of realizations and the state of the run in one line."""
        with self._lock:
            return "its folder is gone" if self.deleted else state_line(self.run)

    def summary(self) -> Summary:
        """Read new members, and return the summary: the same object if it is unchanged."""
        with self._lock:
            before, latest = self._latest
            state: Any = "deleted"
            if not self.deleted:
                if self.run.damaged:  # they may be whole again
                    self.run = open_run(self.run.folder, damaged="skip")
                self.run.refresh()
                state = self.run.counts, tuple(self.run.damaged)
            if before == state:
                return latest
            if state == "deleted":
                words = "was deleted or moved; the last results remain on the page"
                latest = latest._replace(problems=[f"{self.run.folder} {words}"])
            else:
                latest = _summarized(self.run)
            self._latest = state, latest
            return latest


def _summarized(run: Run) -> Summary:
    """Return the summary of a run at this moment."""
    problems = [f"{text}. The other realizations are shown." for text in run.damaged.values()]
    problems += gap(run)
    if run.failed:
        problems.append(f"{run.failed} realizations did not converge and are left out of the means")
    none_yet = "No realization yet, so there are no errors to show."
    levels = run.numerics.single
    sound = {level: run.members.sound(level) for level in levels}
    columns = run.numerics.columns
    begun = [c for c in columns if sound[run.numerics.of_column(c)[0]]]
    return Summary(
        problems,
        {c: table_text(budget_table(run, c), PIPED) if c in begun else none_yet for c in columns},
        {c: measured_curves(run, c) for c in begun},
        sound,
        {level: run.kept(level) for level in levels},
        pictured(run),
        {
            angle: reaction_lines(run, run.column(None), angle)
            for angle in run.scene.directions or (None,)
            if len(begun) == len(columns)
        },
    )


def scene_text(run: Run) -> str:
    """Return the scene file, the cell and the grids of a run."""
    sides = " × ".join(f"{1e3 * length:.4g}" for length in run.sides)
    lines = [
        with_short_tables(run.scene.to_toml()).strip(),
        "",
        f"# cell {sides} mm, seed {run.seed}",
    ]
    for number, level in enumerate(run.numerics.levels):
        points = f"{level.shape[0]} × {level.shape[1]} points"
        where = level.where.replace(" in", ", in")
        lines.append(f"# L{number}: {level.column}, {points}, q_c = {level.q_max:.4g} rad/m{where}")
    return "\n".join(lines)


def speed_range(scene: Scene) -> tuple[float, float]:
    """Return the lowest and highest speed of the slider, m/s: a decade beyond the speeds of the scene.

    With a table over temperature, the highest speed of the scene is the limit.
    """
    moving = [speed for speed in scene.speeds if speed > 0.0] or [1.0]
    highest = max(moving)
    if isinf(scene.temperature_range[1]):
        highest = 10.0 ** (ceil(log10(highest)) + 1)
    return 10.0 ** (floor(log10(min(moving))) - 1), highest


def _distances(run: Run) -> Field:
    """Return the r at which g_σ is drawn, m: from a tenth of the shortest wave, at most over four decades, to 0.4
    longest waves, and never beyond half the diagonal.
    """
    first, *_, last = run.scene.spectrum.breaks
    end = min(0.8 * np.pi / first, 0.5 * float(np.hypot(*run.sides)))
    return np.geomspace(max(0.2 * np.pi / last, 1e-4 * end), end, 160)


def theory_curves(
    run: Run, direction: float | None = None
) -> dict[str, tuple[Field, Field, Field]]:
    """Return x, theory and calibrated theory of each curve; temperatures with the heat share of the scene.

    The direction, radians from x, is one of the scene: None of a scene without any.
    """
    scene, r = run.scene, _distances(run)
    if direction is not None:
        scene = scene.towards(direction)
    speeds = np.geomspace(*speed_range(scene), 121)
    # of all the heat; a temperature of the moving body is in proportion to the share that it takes
    theory, law = (
        {name: one[name] * (share if OBSERVABLES[name].heated else 1.0) for name in OVER_SPEED}
        for one, share in (
            (prediction.over_speed(scene, speeds), prediction.heat_partition(scene, speeds)),
            (
                prediction.calibrated_over_speed(scene, speeds),
                prediction.calibrated_share(scene, speeds),
            ),
        )
    )
    correlations = prediction.correlation(scene, r), prediction.calibrated_correlation(scene, r)
    lines = {name: (speeds, theory[name], law[name]) for name in OVER_SPEED}
    return {CORRELATION: (r, *correlations), **lines}


def measured_curves(run: Run, column: str) -> dict[str, Estimate]:
    """Return the curves of a column by name, in all directions; the run needs a sound realization."""
    moving = [speed for speed in run.scene.sliding.speed if speed > 0.0]
    r = _distances(run)
    found = correlation_of(run.samples(column), r)
    scatter = {"statistical": half_width(*spread_of(found))}
    correlation = Estimate.of(CORRELATION, "Pa^2", found.value, {"distance": r}, scatter)
    curves = {CORRELATION: correlation}
    for name in OVER_SPEED:
        curves[name] = run.estimate(name, column).sel(speed=moving)  # a log axis has no zero
    return curves


class Temperature(NamedTuple):
    """A temperature of a member above the mean of the cell, K, at a speed, m/s, and direction, rad from axis 0.

    A preview has no distribution over the contact, and only the long waves of a large field.
    """

    member: "MemberFields"
    field: Field
    grid: Grid
    speed: float
    direction: float
    scene: Scene  # that of the run, or the same with other layers on its bodies
    contact: ContactTemperature | None

    @property
    def preview(self) -> bool:
        """Whether it is a preview: the whole field is still being computed."""
        return self.contact is None


@dataclass(frozen=True, slots=True, eq=False)
class MemberFields:
    """Heights, m, and pressure, Pa, of one member, and its pressure on the grid of the preview."""

    run: Run
    grid: Grid
    heights: Field
    pressure: Field
    preview_grid: Grid
    preview_pressure: Field
    column: str  # whose share of the heat counts

    def temperature(
        self, speed: float, direction: float, scene: Scene | None = None, *, preview: bool = False
    ) -> Temperature:
        """Return the temperature at a speed, m/s, and direction, rad, on the whole grid or on the preview grid.

        `scene` is that of the run if left out; it may have other layers on its bodies, or no camera; neither
        changes the contact.
        """
        scene = self.run.scene if scene is None else scene
        pressure, grid = self.pressure, self.grid
        if preview:
            pressure, grid = self.preview_pressure, self.preview_grid
        name = "temperature" if scene.camera is None else "seen"
        field = self.run.heated(name, pressure, grid, speed, direction, self.column, scene)
        # the heat that a pixel sets free is in proportion to its pressure
        contact = None if preview else contact_temperature(field, pressure)
        return Temperature(self, field, grid, speed, direction, scene, contact)


def load_fields(run: Run, level: int, index: int, preview: int = PREVIEW) -> MemberFields:
    """Read the fields of a member, or compute them again if they were not kept: a member is the same every time.

    `preview` is the largest number of points per side of the preview. RecordError if the file is damaged; ValueError if
    the fields of a map were not kept; ConvergenceError as `realize`.
    """
    grid = run.grid(level)
    if index in run.kept(level):
        heights, pressure = (run.field(level, index, name) for name in ("heights", "pressure"))
    elif (level, index) in run.members.lost or not run.drawn:
        raise run.not_kept(level, index)  # `realize` draws a surface: a map would be another one
    else:
        solved = realize(run.scene, run.numerics, seed=run.seed, level=level, index=index)
        heights = solved.heights.astype(np.float32)
        pressure = solved.contact.pressure.astype(np.float32)
    # the temperature is linear in the heat, wave by wave: the long waves of the pressure give the long waves of it
    coarse = Grid((min(grid.shape[0], preview), min(grid.shape[1], preview)), grid.lengths)
    waves = pressure
    for axis in (0, 1):
        if coarse.shape[axis] < grid.shape[axis]:
            waves = scipy.signal.resample(waves, coarse.shape[axis], axis=axis)
    return MemberFields(
        run, grid, heights, pressure, coarse, waves, run.numerics.levels[level].column
    )


def usual_seconds(run: Run, level: int) -> float:
    """Return the median time of the members of a level, s; 0 without members."""
    times = run.members.seconds(level)
    return float(np.median(times)) if times.size else 0.0


class Image(NamedTuple):
    """Pixels of shape (y, x); left, bottom, width and height, m; values of 0 and 255; points per pixel; its values."""

    pixels: NDArray[np.uint8]
    box: tuple[float, float, float, float]
    limits: Ends
    step: tuple[int, int]
    means: Field


class MapLook(NamedTuple):
    """How a map is shown: colour map ("" for the usual one), limits of its colours, SI, and whether they are log."""

    colours: str = ""
    low: float | None = None
    high: float | None = None
    log: bool = False


USUAL = MapLook()


def image_of(
    field: Field,
    grid: Grid,
    view: tuple[Ends, Ends],
    limits: Ends | None,
    look: MapLook = USUAL,
    pixels: int = PIXELS,
) -> Image:
    """Return the image of the part of a field that meets a view (ends along x and y, m); limits None: its own.

    Limits of the look come first. A log scale has three decades if its lower limit is not above zero.

    The point of index i covers (i ± ½)·spacing. At most `pixels` blocks of points lie along a side; each is shown as
    its mean. Of a view beyond the cell one point stays. Blocks start at multiples of their size, so that an image does
    not shimmer while the view is moved. The last ones may reach beyond the cell; their means are over fewer points.
    """
    means, sides = field, []  # along x and y: begin, end and number of points of each block
    for count, spacing, ends in zip(grid.shape, grid.spacing, view, strict=True):
        first, last = (
            int(np.clip(np.floor(end / spacing + 0.5), 0, count - 1)) for end in sorted(ends)
        )
        step = 1
        while last // step - first // step >= pixels:
            step += 1
        start, stop = first // step * step, (last // step + 1) * step
        means = block_means(means[start:stop], step).T  # the second turn transposes back
        sides.append(((start - 0.5) * spacing, (stop - start) * spacing, step))
    (left, width, x_step), (bottom, height, y_step) = sides
    low, high = limits or (float(means.min()), float(means.max()))
    low, high = low if look.low is None else look.low, high if look.high is None else look.high
    shown, ends = means, (low, high)
    if look.log and high > 0.0:
        low = low if low > 0.0 else 1e-3 * high
        shown, ends = np.log(np.maximum(means, low)), (log(low), log(high))
    box = left, bottom, width, height
    return Image(as_bytes(shown, ends), box, (low, high), (x_step, y_step), means)


def block_means(rows: Field, step: int) -> Field:
    """Return the means of each `step` rows; the last block may have fewer."""
    if step == 1:
        return rows
    starts = np.arange(0, len(rows), step)
    counts = np.diff(starts, append=len(rows)).astype(rows.dtype)
    means: Field = np.add.reduceat(rows, starts, axis=0) / counts[:, None]
    return means


def as_bytes(field: Field, limits: Ends) -> NDArray[np.uint8]:
    """Return 0…255 for values from the lower to the upper limit, shape (y, x) as screens draw; flat fields are 0."""
    low, high = limits
    scale = 255.0 / (high - low) if high > low else 0.0
    return np.ascontiguousarray(
        np.rint(np.clip((field.T - low) * scale, 0.0, 255.0)).astype(np.uint8)
    )


class Line(NamedTuple):
    """Points of a grid along a line: indices i, j, and distance from its middle, m, positive along the direction."""

    distance: NDArray[np.float64]
    i: NDArray[np.intp]
    j: NDArray[np.intp]


def nearest_point(grid: Grid, x: float, y: float) -> tuple[int, int]:
    """Return the indices of the point of the cell that is next to (x, y), m."""
    i, j = (
        int(np.clip(round(at / d), 0, n - 1))
        for at, d, n in zip((x, y), grid.spacing, grid.shape, strict=True)
    )
    return i, j


def line_through(grid: Grid, point: tuple[int, int], direction: float) -> Line:
    """Return the points next to the line through a point along a direction, rad from axis 0 towards axis 1.

    The line reaches from one side of the cell to the other. Its points are one spacing (the smaller one) apart, so that
    a line along an axis has each point of the grid once.
    """
    unit = np.round([cos(direction), sin(direction)], 15)  # exactly 0 along an axis
    step = min(d for d, u in zip(grid.spacing, unit, strict=True) if u != 0.0)
    reach = int(np.hypot(*grid.lengths) / step)
    distance = step * np.arange(-reach, reach + 1.0)
    places = np.reshape(point, (2, 1)) + np.outer(unit / grid.spacing, distance)  # in indices
    last = np.reshape(grid.shape, (2, 1)) - 1
    # a point that lies on a side stays in spite of rounding
    inside = ((places > -1e-6) & (places < last + 1e-6)).all(axis=0)
    i, j = np.rint(places[:, inside]).astype(np.intp)
    return Line(distance[inside], i, j)
