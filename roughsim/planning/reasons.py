"""The choices of a plan in words: its levels, its workers, and the table of all."""

from collections.abc import Iterable, Sequence
from math import prod

from roughsim.grid import Array
from roughsim.machine import SHARE, available_memory, in_words, usable_cores, workers_that_fit
from roughsim.scene import Scene
from roughsim.scene.numerics import Level, Numerics
from roughsim.show.remarks import Remark
from roughsim.show.table import Column, Table, significant


def plan_table(reasons: Sequence[Remark]) -> Table:
    """Return the choices of a plan with their reasons."""
    titles = [Column(title) for title in ("choice", "value", "because")]
    return Table(titles, [reason.row for reason in reasons])


def plan_summary(title: str, numerics: Numerics, sizes: Iterable[Remark]) -> Table:
    """Return the cost, the levels of each column, and values without their reasons, the most important first."""
    reasons = {reason.quantity: reason for reason in numerics.reasons}
    cost = reasons["CPU time"]
    rows = [("CPU time", f"{cost.value}, {cost.text.partition(',')[0]}")]
    for column in numerics.columns:
        levels = [numerics.levels[i] for i in numerics.of_column(column)]
        x, y = _largest(levels)
        q_max = f"{levels[-1].q_max:.3g} rad/m"
        rows.append(
            (
                column,
                f"{len(levels)} level{'s' * (len(levels) > 1)} to q_c = {q_max}, up to {x} × {y} points",
            )
        )
    for name in ("workers", "memory", "slid distance", "slides", "cell", "hardness"):
        if name in reasons:
            rows.append((name, reasons[name].value))
    if "scan" in reasons:
        rows.append(("error by the scan", reasons["scan"].value))
    first = ("T_flash", "contact area")
    weighed = sorted(sizes, key=lambda size: size.quantity not in first)  # else as they are
    rows += [(size.quantity, size.value) for size in weighed]
    return Table([Column("", name=True), Column("")], rows, title)


def opening(scene: Scene, numerics: Numerics, cost: Remark) -> str:
    """Return the first sentence of a run: what it computes, to what target, and about how long."""
    x, y = _largest(numerics.levels)
    goal = cost.text.partition(",")[0]
    if scene.ensemble.realizations is None:
        others = {k: v for k, v in scene.ensemble.ends.items() if k != "flash_temperature"}
        goal += " of T_flash" + "".join(f", {k} {100 * v:g} %" for k, v in others.items())
    contacts = f"{' and '.join(numerics.columns)} contact, up to {x} × {y} points, {goal}"
    return f"{scene.title or 'untitled'}: {contacts}; about {cost.value} of CPU time in all."


def _largest(levels: Iterable[Level]) -> tuple[int, int]:
    """Return the points along x and y of the largest grid."""
    return max((level.shape for level in levels), key=prod)


def workers_reason(numerics: Numerics, first: tuple[float, str], largest: float) -> Remark:
    """Return the number of processes whose members fit into memory together.

    `first` is the largest member of the first round, bytes, and its name, `largest` that of all levels.
    ResolutionError if the first does not fit: a run may end before it needs the others.
    """
    cores, memory = usable_cores(), available_memory()
    room, wanted = SHARE * memory.amount, max(int(cores.amount) // numerics.threads, 1)
    most = workers_that_fit(wanted, *first, memory)
    least = workers_that_fit(wanted, min(largest, room), "", memory)
    reason = f"one per core ({cores.source})" + f", {numerics.threads} threads each" * (
        numerics.threads > 1
    )
    if least < wanted:
        reason = f"{wanted} would need more than {100 * SHARE:.0f} % of the {in_words(memory)}"
    if largest > room:
        reason = f"{reason}; the largest member alone would, too: a run that comes to need it ends there with an error"
    return Remark("choice", "workers", reason, str(most) if least == most else f"{least} to {most}")


def level_text(levels: Sequence[Level]) -> str:
    """Return grids and cut-offs in words, with their columns if there are several."""
    texts = (
        f"{level.column} " * (len(levels) > 1)
        + f"{level.shape[0]} × {level.shape[1]} to q_c = {level.q_max:.3g} rad/m"
        + level.where
        for level in levels
    )
    return "; ".join(texts)


def at_speeds(values: Array) -> str:
    """Return the numbers at the speeds of a scene, as "0.11, 0.09"; one if they are equal."""
    return ", ".join(dict.fromkeys(f"{value:.4g}" for value in values))


def span(seconds: float) -> str:
    """Return a rough time span in words: 12 s, 3.5 min, 2 h."""
    unit, length = (
        ("s", 1.0) if seconds < 120.0 else ("min", 60.0) if seconds < 7200.0 else ("h", 3600.0)
    )
    return f"{significant(seconds / length, 2)} {unit}"
