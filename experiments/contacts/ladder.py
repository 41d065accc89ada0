"""Contacts that yield, one by one: members on a ladder of cut-offs or of pixels, and all that is reported, with errors.

Roughness without end is cut at q_c = 4, 8, 16 … q_y at two pixels per shortest wave, and the limit is that of
`limit.ladder_end`. Roughness that ends is solved whole at 2, 4, 8 … pixels per shortest wave, and the limit of
vanishing pixels is taken in the same way. The cell of the ladder holds two of the longest waves. What a larger cell
changes is measured on the first rung, by cells with up to four times its side. On a ladder of cut-offs that fades as
all yields (at rest, with sigma_0/sigma_P = 0.0055: 2.2, 0.6, 0.2 % on the first three rungs), so half of it is taken,
and as much doubted. Units: E* = 1, q_r = 1, mu = kappa = D = 1; T_flash stands for <T sigma>, so that theory gives it
with friction_coefficient = nominal_pressure.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import pi
from typing import Any

import numpy as np
from scipy.special import j0

import roughsim as rs
from contacts import members
from contacts.limit import chain, half_width, ladder_end
from contacts.members import PECLET

LOWEST, PIXELS = (
    4.0,
    2.0,
)  # q_c/q_y of the first rung of roughness without end; pixels per shortest wave
SIDE = 4096  # the most points along a side
STEEP, ENOUGH = (
    0.65,
    4,
)  # from that H on, and on ladders of pixels, so many rungs end at half that side
FINEST = 32.0  # the most pixels per shortest wave
EFFORT = 1e7  # pixels of all members of a rung
FEWEST, MOST = 6, 256  # members of a rung
WIDER = 4  # the large cell: its side over that of the others, or half of it where its grid would pass half of SIDE
FADED = 0.5  # of what the large cell changes is taken on a ladder of cut-offs, and as much doubted
SIZE_DOUBT = 0.3  # of what it changes on a ladder of pixels: a third or less is left if it falls as the area of the cell
PIXEL_DOUBT = 0.004  # of T_flash without end: its limit with two pixels per shortest wave against that with four
DISTANCES = 0.05 * 1.12 ** np.arange(64)  # of g_sigma(r), in 1/q_r
KEPT, END = 20, 0.1  # of them are reported, up to g_sigma(r)/g_sigma(0) = END
EDGES = 2.0 ** (np.arange(-18, 43) / 3)  # bands of q/q_r: three an octave
SEEN = 0.6  # of the Nyquist wavenumber: above, the grid distorts the stress
SPEEDS = [f"flash_temperature-{pe:g}" for pe in PECLET]
COLUMNS = [
    "contact_fraction",
    "yielded_fraction",
    *SPEEDS,
    "pressure_variance",
]  # then g_sigma(r), then the bands


@dataclass(frozen=True)
class Rung:
    """One level: C(q) up to `q_max` on a square grid, `periods` waves of q_r along its side; how many members."""

    q_max: float
    side: int
    periods: float
    members: int

    @property
    def grid(self) -> rs.Grid:
        """The periodic cell."""
        return rs.Grid((self.side, self.side), (self.periods * 2 * pi,) * 2)

    @property
    def pixels(self) -> float:
        """Pixels per shortest wave."""
        return self.side / (self.periods * self.q_max)


def ladder(contact: Any, effort: float = EFFORT, most: int = SIDE) -> tuple[Rung, list[Rung]]:
    """Return the large cell of the first rung, and all rungs."""
    endless = np.isinf(contact.q_max)
    q_max = LOWEST * contact.yields if endless else contact.q_max
    side = _fast(PIXELS * q_max * contact.periods)
    wider = WIDER if WIDER * side <= most // 2 else WIDER // 2
    large = Rung(q_max, wider * side, wider * contact.periods, _count(wider * side, effort))
    rungs: list[Rung] = []
    steep = contact.hurst > STEEP or not endless
    while side <= (most // 2 if steep and len(rungs) >= ENOUGH else most):
        rungs.append(Rung(q_max, side, contact.periods, _count(side, effort)))
        if rungs[-1].pixels > 0.75 * FINEST:
            break
        side, q_max = 2 * side, q_max * (2.0 if endless else 1.0)
    return large, rungs


def _fast(least: float) -> int:
    """Return the next number of points that is 2, 3 or 5 times a power of two, and has members enough."""
    return min(
        factor * 2**k for factor in (1, 3, 5) for k in range(3, 13) if factor * 2**k >= least
    )


def _count(side: int, effort: float) -> int:
    return int(np.clip(effort / side**2, FEWEST, MOST))


def members_of(contact: Any, rung: Rung, stream: list[int]) -> Any:
    """Return what is measured of each member of a rung: shape (members, columns). `stream` and the index seed it."""
    solid, spectrum = rs.Solid(1.0, contact.hardness), contact.spectrum(rung.q_max)
    matrix, place = _kernels(rung.grid), np.digitize(members.radial(rung.grid).wavenumber, EDGES)
    rows = []
    for index in range(rung.members):
        heights = rs.synthesize(spectrum, rung.grid, np.random.default_rng([*stream, index]))
        solved = rs.solve_contact(
            heights, rung.grid, solid, nominal_pressure=contact.load, tolerance=1e-4
        )
        stress = members.stress_table(solved.pressure, rung.grid)
        areas = rs.corrected_fractions(solved.pressure, contact.hardness)
        bands = np.bincount(place, stress, minlength=EDGES.size + 1)[1:-1]
        rows.append(np.concatenate([areas, stress @ matrix, bands]))
    return np.array(rows)


@lru_cache(maxsize=2)
def _kernels(grid: rs.Grid) -> Any:
    """Return f of T_flash at all Péclet numbers, of g_sigma(0), and of g_sigma(r) by bin: shape (bins, functionals)."""
    q = members.radial(grid).wavenumber
    return np.column_stack([members.kernel_matrix(q), *(j0(q * r) for r in DISTANCES)])


def measure(contact: Any, large: Rung, rungs: list[Rung], stream: list[int]) -> dict[str, Any]:
    """Solve the members of all rungs, which share their streams, and those of the large cell."""
    result = {"large": members_of(contact, large, [*stream, 1])}
    return result | {
        f"rung{k}": members_of(contact, rung, [*stream, 0]) for k, rung in enumerate(rungs)
    }


@dataclass(frozen=True)
class Solved:
    """The members of a contact: of its rungs, and of the large cell on the first of them."""

    rungs: list[Rung]
    levels: list[Any]
    large: Any

    @property
    def endless(self) -> bool:
        """Whether the rungs are cut-offs of a C(q) without end."""
        return self.rungs[-1].q_max > self.rungs[0].q_max

    def value(self, column: int, peclet: float | None = None, start: int = 0) -> dict[str, float]:
        """Return the limit of one column with its errors. The ladder begins at rung `start`; `peclet`: of T_flash."""
        logs, wide = (
            [_spread(level[:, column]) for level in self.levels],
            _spread(self.large[:, column]),
        )
        slow, place, pixel = None, 0.0, 0.0
        if peclet is not None and self.endless:
            slow = [_spread(level[:, COLUMNS.index(SPEEDS[0])]) for level in self.levels]
            place, pixel = self.rungs[-1].q_max / peclet, PIXEL_DOUBT
        end = ladder_end(logs[start:], slow, place)
        taken, doubted = (FADED, FADED) if self.endless else (1.0, SIZE_DOUBT)
        change = float(wide.mean() - logs[0].mean())
        causes = [*end.scatter, taken * half_width(wide)]
        if start == 0:
            causes[0] -= taken * half_width(
                logs[0]
            )  # so far the mean of the first rung is that of the large cell
        else:
            causes.append(taken * half_width(logs[0]))
        scatter, size = float(np.linalg.norm(causes)), doubted * abs(change)
        return {
            "value": float(np.exp(end.value + taken * change)),
            "error": float(np.linalg.norm([scatter, end.doubt, size, pixel])),
            "standard_error": scatter / 1.96,
            "bias": float(np.expm1(end.last - end.value)),
            "ladder": end.doubt,
            "size": size,
        }


def values(rungs: list[Rung], raw: dict[str, Any]) -> dict[str, Any]:
    """Return all that is reported of a contact. Errors are relative; "error" is the total one, 95 %."""
    solved = Solved(rungs, [raw[f"rung{k}"] for k in range(len(rungs))], raw["large"])
    speeds = [
        solved.value(COLUMNS.index(name), pe) for name, pe in zip(SPEEDS, PECLET, strict=True)
    ]
    result = {"flash_temperature": {"peclet": PECLET.tolist()} | _joined(speeds)}
    result |= {name: solved.value(COLUMNS.index(name)) for name in COLUMNS if name not in SPEEDS}
    return result | {"correlation": _correlation(solved), "spectrum": finest_spectrum(solved)}


def _correlation(solved: Solved) -> dict[str, list[float]]:
    """Return g_sigma(r) up to where it is END of g_sigma(0); its ladder begins where two pixels are shorter than r."""
    first, variance = len(COLUMNS), COLUMNS.index("pressure_variance")
    pixels = np.array([rung.grid.lengths[0] / rung.side for rung in solved.rungs])
    mean = solved.levels[-1].mean(axis=0)
    end = int(np.argmax(mean[first : first + DISTANCES.size] < END * mean[variance]))
    kept = [k for k in range(max(end - KEPT, 0), end) if DISTANCES[k] > pixels[-1]]
    starts = [min(int(np.sum(2 * pixels > DISTANCES[k])), max(pixels.size - 3, 0)) for k in kept]
    some = [solved.value(first + k, start=start) for k, start in zip(kept, starts, strict=True)]
    return {"r": DISTANCES[kept].tolist()} | _joined(some)


def _spread(column: Any) -> Any:
    """Return ln of the mean, spread over the members to first order."""
    mean = column.mean()
    return np.log(mean) + column / mean - 1.0


def _joined(entries: list[dict[str, float]]) -> dict[str, list[float]]:
    return {key: [entry[key] for entry in entries] for key in entries[0]}


def finest_spectrum(solved: Solved) -> dict[str, list[float]]:
    """Return |sigma_q|^2 of the finest rung by band, below SEEN of its Nyquist wavenumber."""
    rungs, grid = solved.rungs, solved.rungs[-1].grid
    radial = members.radial(grid)
    place = np.digitize(radial.wavenumber, EDGES)[1:]  # without q = 0
    count, total = (
        np.bincount(place, weights[1:], minlength=EDGES.size + 1)[1:-1]
        for weights in (radial.count, radial.count * radial.wavenumber)
    )
    result: dict[str, list[float]] = {"q": [], "value": [], "error": []}
    first = len(COLUMNS) + DISTANCES.size
    for band in np.flatnonzero((count > 0) & (EDGES[1:] <= SEEN * grid.nyquist)):
        held = [
            _spread(level[:, first + band])
            for level, rung in zip(solved.levels, rungs, strict=True)
            if EDGES[band + 1] <= rung.grid.nyquist
        ]
        start, steps, scatter = chain(held)
        area = count[band] / rungs[-1].periods ** 2
        result["q"].append(float(total[band] / count[band]))
        result["value"].append(float(np.exp(start + steps.sum()) / area))
        result["error"].append(float(np.linalg.norm(scatter[-1])))
    return result
