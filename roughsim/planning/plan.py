"""`plan`: from a scene to its numerics by rule, each choice with its reason.

Nothing is solved: the cell, the levels and the cost follow from C(q), the load and the theory. How many members each
level gets is decided by the run itself, round by round. Numerics that the scene states are taken as they are.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from math import inf, isnan, pi, prod, sqrt
from typing import Any

from roughsim import prediction
from roughsim.estimate.rounds import FIRST_STEP, WORK_SECONDS, first_counts, work
from roughsim.grid import Grid
from roughsim.machine import BYTES_PER_POINT, PROCESS
from roughsim.planning.levels import cell_of, levels_of, target_of
from roughsim.planning.limits import judge
from roughsim.planning.reasons import at_speeds, level_text, span, workers_reason
from roughsim.planning.sliding import slide_reasons, with_slide
from roughsim.prediction.scans import scan_of_hottest
from roughsim.scene import Scene, SceneLike, as_scene
from roughsim.scene.checks import check_levels
from roughsim.scene.ensemble import TARGET
from roughsim.scene.numerics import DEFAULT_REASONS, Numerics
from roughsim.show.remarks import Remark, warn_of

# relative standard deviation of T_flash over the members of a lowest level, × longest waves per side × √(contact area
# of the theory there): smallest and largest of 20 scenes, elastic and capped, with contact on .0005 … .25 of the area
_SCATTER = 0.012, 0.046


def plan(
    scene: SceneLike,
    target_error: float | str | None = None,
    *,
    changes: Mapping[str, Any] | None = None,
) -> Numerics:
    """Choose the numerics of a scene by rule; keys given in its [numerics] section are kept.

    A `SceneWarning` names each number beyond the model, and each assumption that is easily missed.

    Parameters
    ----------
    scene : Scene, str, path or dict
        Scene to compute, or an argument of `load_scene`.
    target_error : float or str, optional
        Target for the relative total error of T_flash, such as 0.02 or "2 %". Default: from the scene's
        `until`, or 1 %.
    changes : mapping, optional
        Other values of some keys of the scene, as for `load_scene`.

    Returns
    -------
    Numerics
        With `reasons`, one for each choice.

    Raises
    ------
    ValueError
        If `target_error` is not in (0, 1).
    ResolutionError
        If the machine has too little memory for the first round.
    """
    changes = dict(changes or {})
    if target_error is not None:
        target = TARGET(target_error, "target_error")
        changes["ensemble.until.flash_temperature"] = target
    scene = as_scene(scene, changes)
    numerics = numerics_of(scene)
    warn_of(judge(scene, numerics).remarks)
    return numerics


def numerics_of(scene: Scene) -> Numerics:
    """Return the numerics of a scene for its own target, as `plan`, without warnings."""
    stated, scene = scene, prediction.computed(scene)
    reasons = []
    if scene != stated:
        why = "in theory next to nothing of the contact reaches it: the contact is elastic"
        reasons.append(
            Remark(
                "choice", "hardness", why, f"{stated.penetration_hardness / 1e9:.3g} GPa left out"
            )
        )
    prediction.background(scene)  # refuses a duration that is too short for a skin
    target = target_of(scene)
    lengths, why = cell_of(scene)
    x, y = Grid((1, 1), lengths).stretched(scene.lay).lengths
    sides = f"{x * 1e3:.4g} mm × {y * 1e3:.4g} mm"
    if scene.lay > 1.0:
        why += "; stretched by the lay, which keeps its points and area"
    if scene.lays_differ:
        why += "; for lays that differ pixels are square, at up to γ times the points of one lay"
    reasons.append(Remark("choice", "cell", why, sides))
    if scene.numerics.levels is not None:
        levels = scene.numerics.levels
        reasons.append(Remark("choice", "levels", "given in the scene", level_text(levels)))
    else:
        coarse = levels_of(scene, lengths, target)
        levels = tuple(level.level for level in coarse)
        reasons += (
            Remark("choice", level.level.column, level.reason, level_text((level.level,)))
            for level in coarse
        )
    keys = {key: getattr(scene.numerics, key) for key in DEFAULT_REASONS}
    keys = {key: value for key, value in keys.items() if value is not None}
    numerics = with_slide(scene, Numerics(levels, lengths, **keys))
    check_levels(stated, numerics.levels)
    if not scene.elastic and "elastic" in numerics.columns:
        raise ValueError(
            'column = "elastic" does not fit a scene with a hardness; use "smoothed" or "capped"'
        )
    reasons += _heat_reasons(scene)
    for key, why in DEFAULT_REASONS.items():
        value = getattr(numerics, key)
        text = "L/2" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
        reasons.append(Remark("choice", key, "given in the scene" if key in keys else why, text))
    member, why = largest_member(scene, numerics, range(len(numerics.levels)))
    return replace(
        numerics,
        reasons=(
            *reasons,
            *slide_reasons(scene, numerics),
            cost_of(scene, numerics),
            workers_reason(numerics, largest_member(scene, numerics), member),
            Remark(
                "choice",
                "memory",
                f"{member / 1e9:.2g} GB for {why}",
                f"{(member + PROCESS) / 1e9:.2g} GB per worker",
            ),
        ),
    )


def largest_member(
    scene: Scene, numerics: Numerics, levels: Collection[int] | None = None
) -> tuple[float, str]:
    """Return the memory of the largest member of some levels, by default of the first round, bytes, and its name."""
    if levels is None:
        levels = [level for level, count in enumerate(first_counts(numerics, 1)) if count]
    memory = (
        BYTES_PER_POINT * max(prod(numerics.levels[level].shape) for level in levels),
        "largest grid",
    )
    if numerics.slide not in levels:
        return memory
    from roughsim.planning.realization import slide_problem  # slow to import; most have no slide

    slide = (
        slide_problem(scene, numerics).memory,
        "the slide: both bodies remember their heat, at each speed",
    )
    return max(memory, slide)


def _heat_reasons(scene: Scene) -> Iterator[Remark]:
    """Yield the average of the moments, the constants used for tables, and the error of a measured C(q)."""
    averaged = "averaged over all sliding directions in closed form; drawn surfaces are isotropic"
    if scene.directions:
        averaged = "in each direction, half the cell along it after the start from rest: no track meets itself"
    yield Remark("choice", "moments", averaged, "all speeds at once")
    if "conductivity" in scene.tables:
        text = f"{at_speeds(prediction.conduction(scene).conductivity)} W/(m K)"
        why = "of the moving body at T₀ + 0.75 T_flash of the theory"
        yield Remark("choice", "conductivity", why, text)
    if "friction_coefficient" in scene.tables:
        text = at_speeds(prediction.friction_coefficient(scene))
        why = "at T₀ + T_flash of the theory, speed by speed"
        yield Remark("choice", "friction_coefficient", why, text)
    scan = scan_of_hottest(scene)
    if scan is not None:
        text = "unknown" if isnan(scan) else f"{100 * scan:.2g} % of the highest T_flash"
        why = "the error of the scan that C(q) was measured on; no member lowers it"
        yield Remark("choice", "scan", why, text)


def cost_of(scene: Scene, numerics: Numerics) -> Remark:
    """Return the approximate CPU time of a run up to the relative total 95 % error of T_flash of its scene.

    The least is the first round, or two levels of the main column with little scatter; the most has much scatter, and
    all levels.
    """
    most, fixed = scene.ensemble.most, scene.ensemble.realizations is not None
    target = target_of(scene)
    main = numerics.coarse_levels(numerics.columns[-1])
    area = prediction.area_fractions(scene, numerics.levels[main[0]].q_max)["contact_fraction"]
    waves = min(numerics.lengths) * scene.spectrum.breaks[0] / (2 * pi)
    works = [work(numerics, i) for i in numerics.single]
    first = sum(
        n * each for n, each in zip(first_counts(numerics, most), works, strict=False)
    )  # without the slide
    wanted, spent = [], []
    for scatter, coarse in zip(_SCATTER, (main[:2], main), strict=True):
        # levels have members in proportion to scatter/√work; each correction scatters half as much as the level below,
        # and more in a part of the cell
        falls = [numerics.levels[i].parts / 2.0**k for k, i in enumerate(coarse)]
        total = sum(
            fall * sqrt(works[i] / works[main[0]]) for fall, i in zip(falls, coarse, strict=True)
        )
        wanted.append((2.0 / target * scatter / waves) ** 2 / area * total if area else inf)
        spent.append((most if fixed else min(wanted[-1], most)) * works[main[0]] * total)
    low, high = max(first, spent[0]), max(first, spent[1]) + FIRST_STEP * sum(works)
    goal = f"to a total error of {100 * target:.3g} %"
    if fixed:
        goal = f"of realizations = {most}"
    elif most < wanted[0] < inf:
        goal = f"of max_realizations = {most}; at least some {wanted[0]:.0f} are needed {goal}"
    why = (
        f"{goal}, from the scatter of T_flash on other scenes; the upper end if all levels are needed. After the first "
        "round `roughsim status` shows the time left, as it was measured"
    )
    text = f"{span(WORK_SECONDS * low)} to {span(WORK_SECONDS * high)}"
    return Remark("choice", "CPU time", why, text)
