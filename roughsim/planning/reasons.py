"""The choices of a plan in words: its levels, its expected errors and times, and the table of all."""

from collections.abc import Sequence
from math import hypot, isfinite, isnan

from roughsim.grid import Array
from roughsim.machine import SHARE, available_memory, in_words, usable_cores, workers_that_fit
from roughsim.scene.numerics import Forecast, Level, Numerics, Reason
from roughsim.show.table import Column, Table


def plan_table(reasons: Sequence[Reason]) -> Table:
    """Return the choices of a plan with their reasons."""
    return Table([Column(title) for title in ("choice", "value", "because")], reasons)


def forecast_reasons(forecast: Forecast, scan: float | None, missed: float | None) -> list[Reason]:
    """Return the expected error of a run, as a reason of its plan.

    `scan` is the relative error by the scan; `missed` the target, where systematic errors put it out of reach.
    """

    def percent(error: float) -> str:  # one realization shows no scatter, one cut-off no bandwidth
        return f"{100 * error:.2g} %" if isfinite(error) else "unknown"

    unknown = isnan(forecast.bandwidth)
    parts = (
        f"expected of the highest T_flash: statistical {percent(forecast.statistical)}, bandwidth "
        f"{percent(forecast.bandwidth)}, pixel {percent(forecast.pixel)}, size {percent(forecast.size)}"
        + ("" if scan is None else f", scan {percent(scan)}")
    )
    if missed is not None:
        parts += f"; the target of {percent(missed)} is out of reach: realizations lower the statistical part alone"
    unseen = scan is not None and isnan(scan)
    total = percent(hypot(forecast.total, 0.0 if scan is None or unseen else scan))
    total += " at q_c: what shorter waves change is unknown" * unknown
    return [Reason("error", total + " without the scan's own error" * unseen, parts)]


def workers_reason(numerics: Numerics, member: float, why: str) -> Reason:
    """Return how many processes would compute members of so many bytes, and how long; ResolutionError if none can."""
    cores, memory = usable_cores(), available_memory()
    wanted = max(int(cores.amount) // numerics.threads, 1)
    workers = workers_that_fit(wanted, member, why, memory)
    reason = f"one per core ({cores.source})" + f", {numerics.threads} threads each" * (numerics.threads > 1)
    if workers < wanted:
        reason = f"{wanted} would need more than {100 * SHARE:.0f} % of the {in_words(memory)}"
    if (forecast := numerics.forecast) is not None:
        reason += (
            f": {forecast.wall_seconds(workers):.2g} s; {forecast.cpu_seconds:.2g} s of CPU time for all solves, "
            "within a factor of two; to start a process takes a few seconds more"
        )
    return Reason("workers", str(workers), reason)


def level_text(levels: Sequence[Level]) -> str:
    """Return grids and cut-offs in words, with the column of each where there are several."""
    texts = (
        f"{level.column} " * (len(levels) > 1)
        + f"{level.shape[0]} × {level.shape[1]} to q_c = {level.q_max:.3g} rad/m"
        + level.where
        + f", 1 in {level.every}" * (level.every > 1)
        for level in levels
    )
    return "; ".join(texts)


def at_speeds(values: Array) -> str:
    """Return the numbers at the speeds of a scene, as "0.11, 0.09"; one if they are equal."""
    return ", ".join(dict.fromkeys(f"{value:.4g}" for value in values))
