"""The slide of one body over the other in a plan: its level, its cost, and the reason of a frozen scene."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from roughsim import prediction
from roughsim.planning.levels import fast_size
from roughsim.prediction.sliding import CONTINUED, FURTHEST, continuation_fault
from roughsim.scene import Scene
from roughsim.scene.numerics import SLIDING, Level, Numerics
from roughsim.show.remarks import Remark
from roughsim.show.text import clock
from roughsim.sliding.path import COARSER, oblique_path, pixel_of_path
from roughsim.sliding.snapshots import snapshot_shape

if TYPE_CHECKING:
    from roughsim.sliding.member import SlideProblem

_SIDE, _MOST_SIDE = 256, 512  # points of the cell: usual, and at most
_PIXELS = 4  # per shortest wave: a slide shows its error of the pixel by a coarser grid alone, of 3
_LEAST_CUT_OFF = 4.0  # q_y
_LEAST_CONTINUED = 1.5  # whole slid distance over the followed one: less saves little
_MEMBERS = 8  # the ratio of sliding to frozen scatters little from one to the next
STEP_SECONDS = (
    2.5e-7,
    2.1e-7,
)  # s of CPU time of a step over its points: of the contact, and of each speed
_OF_FROZEN = (
    'the contact slides on unchanged, as if the counterface alone were rough. With history = "sliding" both faces '
    "move, and T_flash is another, by the roughness and the conduction of each: `roughsim theory` of the scene with "
    "this history and a slid_distance has it beside the frozen contact, with its error"
)


def with_slide(scene: Scene, numerics: Numerics) -> Numerics:
    """Return the numerics with a level for the slide.

    Numerics with a slide, and the numerics of a frozen scene, are returned unchanged.
    """
    if scene.sliding.history != SLIDING or numerics.slide is not None:
        return numerics
    return replace(numerics, levels=(*numerics.levels, slide_level(scene, numerics)))


def slide_level(scene: Scene, numerics: Numerics) -> Level:
    """Return the level of a slide: `_SIDE` points along the longer side of the cell, `_PIXELS` per shortest wave.

    The cut-off of yielding contact is at least `_LEAST_CUT_OFF`, beyond which the ratio of sliding to frozen hardly
    depends on it, as far as `_MOST_SIDE` points hold it, and at most that of the highest level. In elastic contact the
    ratio changes by −.5 … −2.7 % from 128 to 256 points, and by −.4 … −1.8 % from 256 to 512.
    """
    highest = numerics.levels[numerics.coarse_levels(numerics.columns[-1])[-1]]
    least = 0.0 if scene.elastic else _LEAST_CUT_OFF * prediction.yield_wavenumber(scene)
    usual, most = (
        2 * pi * side / (_PIXELS * max(numerics.lengths)) for side in (_SIDE, _MOST_SIDE)
    )
    q_max = min(highest.q_max, max(usual, min(least, most)))
    x, y = (fast_size(_PIXELS * q_max * side / (2 * pi)) for side in numerics.lengths)
    return Level(
        SLIDING, (x, y), q_max, first=_MEMBERS, followed=_followed([scene], numerics.lengths[0])
    )


def _followed(scenes: Sequence[Scene], length: float) -> float | None:
    """Return the distance that slides are followed, m: once around their cell; None: the whole slid distance.

    The theory continues T_flash and the share where `continuation_fault` finds no fault, but no picture of a camera.
    """
    furthest = max(max(scene.sliding.distances) for scene in scenes)
    followed = max(length, furthest / FURTHEST)
    if furthest < _LEAST_CONTINUED * followed:
        return None
    whole = any(scene.camera or continuation_fault(scene) for scene in scenes)
    return None if whole else followed


def with_common_slide(planned: Scene, numerics: Numerics, scenes: Iterable[Scene]) -> Numerics:
    """Return the numerics of a scene for several: all slides are followed as far as the longest of them needs.

    Levels that the scenes give are unchanged. ValueError if the theory cannot continue the slides of a scene.
    """
    if numerics.slide is None:
        return numerics
    level, scenes = numerics.levels[numerics.slide], list(scenes)
    if level not in (planned.numerics.levels or ()):
        level = replace(level, followed=_followed(scenes, numerics.lengths[0]))
    for scene in scenes:
        prediction.check_continuation(scene, level.followed, numerics.lengths[0])
    common = replace(numerics, levels=(*numerics.levels[: numerics.slide], level))
    new = {reason.quantity: reason for reason in slide_reasons(planned, common)}
    return replace(
        common, reasons=tuple(new.get(reason.quantity, reason) for reason in numerics.reasons)
    )


def slide_reasons(scene: Scene, numerics: Numerics) -> Iterator[Remark]:
    """Yield level and cost of the slide; for a frozen scene of two rough faces, the effect of a slide."""
    if numerics.slide is None:
        if len(scene.faces) == 2 and scene.counterface_conducts:
            yield Remark("choice", "history", _OF_FROZEN, "frozen")
        return
    # slow to import, and most scenes have no slide
    from roughsim.planning.realization import slide_problem
    from roughsim.sliding.member import snapshot_steps

    level, problem = numerics.levels[numerics.slide], slide_problem(scene, numerics)
    x, y = level.shape
    why = "a low cut-off: the ratio of sliding to frozen contact hardly depends on q_c, and carries over to all of C(q)"
    if scene.numerics.levels is not None and level in scene.numerics.levels:
        why = "given in the scene"
    yield Remark("choice", SLIDING, why, f"{x} × {y} to q_c = {level.q_max:.3g} rad/m")
    distances, step = np.array(problem.distances), pixel_of_path(problem.cell)
    steps = problem.steps
    lengths = " … ".join(
        dict.fromkeys(f"{1e3 * end:.3g}" for end in (distances.min(), distances.max()))
    )
    fresh = f"{distances.max() / problem.cell.lengths[0]:.2g} lengths of the cell"
    why = f"{fresh}, in {steps} steps of {1e6 * step:.3g} µm"
    whole = 1e3 * max(scene.sliding.distances)
    if level.followed is not None and 1e3 * level.followed < whole:
        why += f"; the theory continues it to {whole:.3g} mm, within {100 * CONTINUED:.2g} %"
    yield Remark("choice", "slid distance", why, f"{lengths} mm")
    realizations = scene.ensemble.most
    members = min(level.first or realizations, realizations)
    pixels = f" with one of {COARSER:g} of the points, which shows the error of the pixel" * (
        problem.coarser is not None
    )
    cost = f"about {clock(seconds_of_slide(problem))} of CPU time each{pixels}"
    broken = "one that is broken off begins again"
    why = f"{cost}; {broken}; means are over the last half of the slid distance"
    yield Remark("choice", "slides", why, str(members))
    if pictured := min(numerics.keep_fields, members):
        sides = snapshot_shape(problem.grid.shape)
        positions = len(snapshot_steps(oblique_path(problem.cell, distances.max())))
        most = 4e-6 * positions * sides[0] * sides[1] * (1 + distances.size)
        why = f"maps of the first {pictured} for roughsim explore; keep_fields = 0 leaves them out"
        yield Remark("choice", "snapshots", why, f"{positions} positions, up to {most:.2g} MB")


def seconds_of_slide(problem: "SlideProblem") -> float:
    """Return the approximate CPU time of a slide, s; each speed is computed over its own distance."""
    contact, heat = STEP_SECONDS
    followed = sum(problem.distances) / max(problem.distances)
    both = 1.0 + COARSER**3 * (
        problem.coarser is not None
    )  # the slide on the coarser grid comes after it
    return problem.steps * both * problem.grid.points * (contact + heat * followed)
