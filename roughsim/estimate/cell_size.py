"""The periodic cell: the length of its sides, and the error of its finite size.

Each cell bears the same load, while in an infinite plane the load gathers on high asperities. So a small cell has too
low a T_flash. Its relative error falls with the number N of asperities, whose size follows from the autocorrelation ρ
of the heights after yielding:

    error = (a/A + b) / N,    N = L²/∫(ρ + ρ²)d²r

The share A of asperities that carry load equals the contact fraction of waves down to half an asperity. The constants
were measured for T_flash at low speed, where the error is largest, on scenes made by hand, in cells of 2 to 16 waves,
and tested on scenes drawn at random (`experiments/cell_size.py`). Neither a run nor the theory shows the error of its
cell: the theory summed over the modes of a cell with four longest waves per side is within 0.6 % of its integral.
"""

from collections.abc import Callable
from math import hypot, inf, nan, pi, sqrt

from roughsim import prediction
from roughsim.scene import Scene

# relative error × number of asperities, by the same experiment: times A if few asperities carry load, and if all do
_FEW_ASPERITIES = 0.03
_ALL_ASPERITIES = 0.2
_ELASTIC = 0.4  # of A: elastic contact errs as if on fewer asperities, by the same experiment
# of a target error, for the squared error of T_flash of capped contact in a part of the cell, by which corrections err.
# In small cells they scatter so much that the uncertainty of the last step adds levels
_PART_SHARE = 0.25
# of a squared target error, for the size of the cell: it always lowers T_flash, so a larger share costs coverage; of 35
# scenes with .2, six took 1.2 to 3.4 times as long, and one 0.6 times
SIZE_SHARE = 0.1
SYSTEMATIC = 0.5  # of it, for errors by levels before one is added; of elastic contact, for size and cut-off together
_WAVES = range(
    4, 33, 2
)  # per side of a cell: pictures and g_σ(r) need four, and grids hold no more than 32


def choose_lengths(
    scene: Scene,
    target: float = inf,
    expected: Callable[[tuple[float, float], int], float] | None = None,
) -> tuple[tuple[float, float], str]:
    """Return the sides of the cell, m, given in the scene or the shortest that suffice, and the reason.

    The squared error of the cell is at most `SIZE_SHARE` of the squared relative error `target`, as far as `_WAVES`
    allow. In elastic contact `expected` gives the error by sides, m, and parts, which is at most `SYSTEMATIC` of it, or
    as small as possible. If C(q) is flat below a roll-off, a side holds at least 8 roll-off waves, or 4 of the longest
    waves: on rocks shorter sides left an error of .7 %.
    """
    if scene.numerics.lengths is not None:
        return scene.numerics.lengths, "given in the scene"
    flat = _plateau_end(scene)
    wave = 2 * pi / (flat or scene.spectrum.breaks[0])
    kind = (
        "roll-off waves (2π/q_roll_off), as C(q) is flat below q_roll_off,"
        if flat
        else "longest waves (2π/q_min)"
    )
    least = min(8.0, 4.0 * flat / scene.spectrum.breaks[0]) if flat else 4.0
    choices = [n for n in _WAVES if n >= 0.99 * least]
    asperity = _effective_asperity(scene, choices[0] * wave)
    errors = {n: _relative(asperity / (n * wave) ** 2) for n in choices}
    waves = first_within(sqrt(SIZE_SHARE) * target, errors)
    if (
        expected is not None
    ):  # without 1 part: on the same grid half of a larger cell took half of the time
        together = {
            n: min(expected((n * wave, n * wave), parts) for parts in (4, 2)) for n in choices
        }
        waves = first_within(sqrt(SYSTEMATIC) * target, together)
    why = ", as in fewer too few asperities carry the load" if waves > choices[0] else ""
    reason = f"{waves} {kind} per side{why}; a larger cell changes T_flash by {100 * errors[waves]:.1g} %"
    return (waves * wave, waves * wave), reason


def first_within(most: float, errors: dict[int, float]) -> int:
    """Return the first choice whose error is at most `most`; if there is none, the last of those with the least."""
    least = min(reversed(errors), key=errors.__getitem__)
    return next((choice for choice, error in errors.items() if error <= most), least)


def parts_of(scene: Scene, lengths: tuple[float, float], target: float, column: str = "") -> int:
    """Return the ratio of these sides, m, to the sides of a smaller cell for corrections: 4, 2, or 1 for no such cell.

    The relative error of T_flash in the smaller cell is at most `target` in smoothed contact; in capped contact its
    square is at most `_PART_SHARE` of the target.
    """
    most = target if column == "smoothed" else sqrt(_PART_SHARE * target)
    asperity = _effective_asperity(scene, min(lengths), column)
    return next(
        (parts for parts in (4, 2) if _relative(asperity * (parts / min(lengths)) ** 2) <= most), 1
    )


def size_error(
    scene: Scene,
    lengths: tuple[float, float],
    observable: str = "",
    column: str = "",
    parts: int = 1,
) -> float:
    """Return the relative error by the finite cell of a mean, with corrections from a cell of 1/`parts` of the sides.

    The shorter of the sides, m, counts. Default column: capped or elastic. Elastic corrections erred by a third of the
    error e of T_flash in their cell: half is charged; capped ones err by e². NaN for the first zero of g_σ: it jumped
    by 40 % in a steel whose g_σ only touches zero.
    """
    if observable == "correlation_radius_0":
        return nan
    asperities = min(lengths) ** -2 * _effective_asperity(scene, min(lengths), column)
    if parts == 1:
        return _relative(asperities)
    of_part = _relative(parts**2 * asperities)
    charged = 0.5 * of_part if _is_elastic(scene, column) else of_part**2
    return hypot(_relative(asperities), charged)


def _effective_asperity(scene: Scene, side: float, column: str = "") -> float:
    """Return the area of a cell, m², in which the error would be as large as the value: a/A + b asperities."""
    area, share = prediction.asperities(scene, side)
    if area == 0.0:  # all of the roughness yields
        return 0.0
    if share == 0.0:  # the theory's contact is too small for a number
        return inf
    carrying = _ELASTIC * share if _is_elastic(scene, column) else share
    return (_FEW_ASPERITIES / carrying + _ALL_ASPERITIES) * area


def _is_elastic(scene: Scene, column: str) -> bool:
    return scene.elastic or column == "smoothed"


def _relative(excess: float) -> float:
    """Return an error relative to the true value from the error relative to the value found."""
    return 1.0 - 1.0 / (1.0 + excess)


def _plateau_end(scene: Scene) -> float | None:
    """Return q_roll_off if each rough face is flat (m < 1) below it, else None."""
    ends = []
    for face in (
        scene.surface,
        scene.counterface if scene.counterface and scene.counterface.rough else None,
    ):
        if face is None:
            continue
        kink = face.q_roll_off
        flat = (face.roll_off_exponent or 0.0) < 1.0
        if kink is None or face.q_min is None or kink <= face.q_min or not flat:
            return None
        ends.append(kink)
    return min(ends)
