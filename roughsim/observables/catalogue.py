"""All observables of a run in one table: a new one is a new row here, in the order of all tables and files.

Flash temperature, its gradient and Laplacian, width and slope length: Eqs. (3)–(9), (25), (26). Correlation of the
pressure: Eqs. (1), (2). Another package adds a tuple of records by an entry point of the group "roughsim.observables":
NAME = "package.module:tuple".
"""

from collections import Counter
from collections.abc import Container, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from roughsim.extensions import extensions
from roughsim.grid import Array
from roughsim.observables.distribution import (
    LEVELS,
    Distribution,
    Pooled,
    pooled_quantiles,
    shares_of,
)
from roughsim.observables.record import Measured, Observable, Sample, bins_of, ratio


@dataclass(frozen=True, slots=True)
class SlideCurve:
    """A curve over the slid distance, stored by each member of a slide."""

    unit: str
    per_speed: bool  # shape (speeds, distances), else (distances,)
    description: str


CAMERA = "camera"
DISTRIBUTION = "distribution"
ASKED_BY = {  # the lines of a scene that ask for observables
    DISTRIBUTION: "[observables] temperature_distribution = true",
    CAMERA: "a section [camera]",
}
# of the picture of faces with a lay, at distances across sliding: of others they follow from the stress spectra
CORRELATIONS = tuple(f"seen_correlation_{k}" for k in range(49))
_IN_DIRECTIONS = "directed camera"
_FRACTIONS = (0.5, 0.1, 0.0)  # of g(0) that the correlation falls to at its radii


def radius(sample: Sample, fraction: float) -> Array:
    """Return influence values of the smallest r with g(r) = fraction·g(0) of the mean spectrum; NaN if there is none.

    A change δg of one realization moves the crossing by −δg/g′.
    """
    from scipy.special import j0, j1  # slow to import

    q = sample.wavenumber
    mean = sample.spectrum.mean(axis=0)
    r = sample.kept(f"r({fraction})", lambda s: _crossing(s, fraction))
    if not np.isfinite(r):
        return np.full((len(sample.spectrum), 1), np.nan)
    slope = -float((mean * q) @ j1(q * r))
    excess = sample.spectrum @ (j0(q * r) - fraction)
    return (r - excess / slope)[:, None]


def _crossing(sample: Sample, fraction: float) -> float:
    """Return the smallest r with g(r) = fraction·g(0), searched from the r of the next larger fraction on."""
    from roughsim.observables.stress_spectrum import StressSpectrum  # slow to import

    larger = min((other for other in _FRACTIONS if other > fraction), default=None)
    start = 0.0
    if larger is not None:
        start = sample.kept(f"r({larger})", lambda s: _crossing(s, larger))
    if not np.isfinite(start):
        return start
    mean = StressSpectrum(sample.wavenumber, sample.spectrum.mean(axis=0), sample.reach)
    return mean.correlation_radius(fraction, start=start)


def correlation_radius(percent: int) -> Observable:
    """Return the record of the distance at which g(r) has fallen to so many percent of g(0)."""
    fraction = percent / 100
    return Observable(
        f"correlation_radius_{percent}",
        "m",
        values=lambda s: radius(s, fraction),
        theory=lambda theory: theory.correlation_radius(fraction),
        spectra=True,
        distance=True,
        pixel_orders=(2.0, np.nan),  # 4, 8, 16, 32 pixels per wave: up by 2 %, then back
        solver_share=1.0,
    )


def quantile(name: str, weight: str) -> Observable:
    """Return the record of a quantile of the temperature by a name of its level; the weight is "heat" or "area"."""
    place = list(LEVELS).index(name)
    whole = f"temperature_quantile_{'area_' * (weight == 'area')}{name}"
    return Observable(
        whole,
        "K",
        stored=f"temperature that {LEVELS[name]:.1%} of the {weight} of the contact does not exceed",
        measure=lambda measured: getattr(measured.distribution, f"by_{weight}")[:, place],
        values=lambda sample: pooled(sample, whole).rows,
        asked=DISTRIBUTION,
        as_flash=True,
        per_speed=True,
        heated=True,
        at_rest=0.0,
        # as T_flash: from 4 to 8 pixels per wave they fall by .5 to 1 %, T_flash by 1 %
        pixel_orders=(2.0, 1.75),
    )


def pooled(sample: Sample, stored: str) -> Pooled:
    """Return a quantile over all contacts of a sample together, (n, speeds); of each it is stored by this name."""
    kind, _, name = stored.rpartition("_")

    def of_all_levels(sample: Sample) -> Pooled:
        shares = shares_of(bins_of(sample), "area" if kind.endswith("_area") else "heat")
        own = np.stack([sample.numbers[f"{kind}_{level}"] for level in LEVELS], axis=-1)
        return pooled_quantiles(shares, own, np.array([*LEVELS.values()]))

    place = list(LEVELS).index(name)
    return Pooled(*(part[..., place] for part in sample.kept(kind, of_all_levels)))


def of_slide(name: str, unit: str, stored: str, *, asked: str = "") -> Observable:
    """Return the record of a number that a slide stores at each speed."""
    return Observable(
        name, unit, stored, only_stored=True, of_slide=True, asked=asked, per_speed=True
    )


def over_frozen(
    name: str, unit: str, slid: str, frozen: str, *, asked: str = ""
) -> Iterator[Observable]:
    """Yield the records of a number of a slide and of its contacts if they slid on frozen, on both of its grids."""
    for each, stored in ((name, slid), (f"frozen_{name}", frozen)):
        yield of_slide(f"sliding_{each}", unit, stored, asked=asked)
        coarser = f"sliding_{each} of the same faces with 4/3 of the pixel"
        yield of_slide(f"sliding_coarser_{each}", unit, coarser, asked=asked)


def seen_correlation(place: int) -> Observable:
    """Return the record of the correlation of the picture at a distance across sliding, by its place."""
    return Observable(
        CORRELATIONS[place],
        "Pa^2 m^2",
        f"(kappa/(mu v))^2 times the correlation of the picture across sliding, distance {place}",
        measure=lambda measured: measured.seen_correlations[:, place],
        only_stored=True,
        asked=_IN_DIRECTIONS,
        per_speed=True,
    )


def slid_quantile(name: str, weight: str) -> Observable:
    """Return the record of a quantile at the last positions of a slide; arguments as of `quantile`."""
    return of_slide(
        f"sliding_{quantile(name, weight).name}",
        "K",
        f"temperature above the moving body's background that {LEVELS[name]:.1%} of the {weight} of the contact "
        "does not exceed, at eight positions on the last half of the slid distance",
        asked=DISTRIBUTION,
    )


def seen(name: str, unit: str, **more: Any) -> Observable:
    """Return the record of a number of a camera's picture, which the scene computes from the stress spectra."""
    return Observable(
        name,
        unit,
        theory=lambda theory: theory.seen(name),
        asked=CAMERA,
        per_speed=True,
        pixel_orders=(2.0, 1.75),  # as T_flash
        **more,
    )


TABLE: tuple[Observable, ...] = (
    Observable(
        "flash_temperature",
        "K",
        stored="<T sigma>/<sigma>, steady sliding, averaged over directions",
        per_speed=True,
        heated=True,
        at_rest=0.0,
        # capped: from 8 to 16 pixels per wave .2 to .4 of the change from 4 to 8
        pixel_orders=(2.0, 1.75),
        solver_share=0.3,
    ),
    Observable(
        "flash_gradient",
        "K/m",
        stored="<dT/dx sigma>/<sigma>, along the sliding velocity",
        per_speed=True,
        heated=True,
        at_rest=0.0,
        limit=False,
        pixel_orders=(2.0, 0.8),
        solver_share=1.0,
    ),
    Observable(
        "flash_laplacian",
        "K/m^2",
        stored="<(d2T/dx2 + d2T/dy2) sigma>/<sigma>",
        per_speed=True,
        heated=True,
        at_rest=0.0,
        limit=False,
        pixel_orders=(0.7, 0.7),
        solver_share=3.0,
    ),
    Observable(
        "flash_width",
        "m",
        values=lambda s: ratio(s.numbers["flash_temperature"], -s.numbers["flash_laplacian"], 0.5),
        per_speed=True,
        limit=False,
        pixel_orders=(0.7, 0.7),
    ),
    Observable(
        "slope_length",
        "m",
        values=lambda s: ratio(s.numbers["flash_temperature"], -s.numbers["flash_gradient"]),
        per_speed=True,
        at_rest=np.inf,
        limit=False,
        solver_share=1.0,
    ),
    Observable(
        "resting_flash_temperature",
        "K",
        stored="<T sigma>/<sigma> of the same heat in a body that does not move under it",
        only_stored=True,
        per_speed=True,
        heated=True,
        solver_share=0.3,
    ),
    Observable(
        "heat_partition",  # of two temperatures of each level: `estimate.levels.values_of`
        "1",
        per_speed=True,
        spectra=True,  # the balance of the two bodies after a time of sliding
        solver_share=0.3,
    ),
    Observable(
        "contact_fraction",
        "1",
        stored="A/A0",
        values=lambda s: s.numbers["contact_fraction_corrected"],
        # elastic: +1.2 and +.3 % at 3 and 6 pixels per wave, mean of 12 drawn scenes
        pixel_orders=(2.0, 0.8),
        by_force_balance=True,
    ),
    Observable(
        "plastic_fraction",
        "1",
        stored="fraction of the cell at the penetration hardness",
        values=lambda s: s.numbers["plastic_fraction_corrected"],
        pixel_orders=(2.0, 0.8),
        by_force_balance=True,
    ),
    Observable(
        "contact_fraction_corrected",
        "1",
        stored="A/A0, corrected for the pixels along the edge of the contact",
        only_stored=True,
    ),
    Observable(
        "plastic_fraction_corrected",
        "1",
        stored="plastic_fraction, corrected for the pixels along its edge",
        only_stored=True,
    ),
    Observable(
        "peak_volume",
        "1",
        stored="<h-t; h>t> / rms h of the surface, less its exact mean over surfaces; t: level of the contact area",
        measure=lambda measured: measured.peak_volume,
        only_stored=True,
    ),
    *over_frozen(
        "flash_temperature",
        "K",
        "<T sigma>/<sigma> above the moving body's background, last half of the slid distance",
        "flash_temperature of the contacts on the last half of the slid distance, each slid on frozen",
    ),
    of_slide(
        "sliding_share",
        "1",
        "share of the heat that enters the moving body, last half of the slid distance",
    ),
    of_slide(
        "sliding_background",
        "K",
        "mean temperature of the surface of the moving body at the end of the slid distance",
    ),
    *(
        record
        for name, unit in {"seen_rms": "K", "seen_99": "K", "seen_width": "m"}.items()
        for record in over_frozen(
            name,
            unit,
            f"{name} of the picture at the end of the slid distance",
            f"{name} of the contacts there if each slid on frozen",
            asked=CAMERA,
        )
    ),
    Observable(
        "pressure_variance",
        "Pa^2",
        stored="<sigma^2> - sigma0^2",
        theory=lambda theory: theory.total(np.ones_like),
        pixel_orders=(2.0, 1.0),
        by_force_balance=True,
        solver_share=1.0,
    ),
    *(correlation_radius(round(100 * fraction)) for fraction in _FRACTIONS),
    *(quantile(name, weight) for weight in ("heat", "area") for name in LEVELS),
    *(slid_quantile(name, weight) for weight in ("heat", "area") for name in LEVELS),
    seen("seen_rms", "K", spectra=True, heated=True, at_rest=0.0),
    seen(
        "seen_99",
        "K",
        stored="temperature above the mean of the surface that 1 % of the picture of the camera exceeds",
        measure=lambda measured: measured.seen_99,
        follows="seen_rms",
        heated=True,
        at_rest=0.0,
    ),
    seen("seen_width", "m", spectra=True),
    *map(seen_correlation, range(len(CORRELATIONS))),
    *(record for entry in extensions("observables").values() for record in entry.load()),
)
OBSERVABLES = {record.name: record for record in TABLE if not record.only_stored}
NUMBERS = {
    record.name: record for record in TABLE if record.stored
}  # stored in the file of each member
AXIS = "slid_distance"
CURVES = {
    AXIS: SlideCurve("m", False, "slid distance"),
    "slide_flash_temperature": SlideCurve(
        "K", True, "<T sigma>/<sigma> of the moving body above its background"
    ),
    "slide_resting_flash_temperature": SlideCurve("K", True, "the same of the resting body"),
    "slide_moving_share": SlideCurve("1", True, "share of the heat that enters the moving body"),
    "slide_background": SlideCurve("K", True, "mean temperature of the surface of the moving body"),
    "slide_resting_background": SlideCurve("K", True, "the same of the resting body"),
    "slide_contact_temperature": SlideCurve(
        "K", True, "<T sigma>/<sigma> of both bodies, background included"
    ),
    "slide_frozen_flash_temperature": SlideCurve(
        "K", True, "T_flash if the contact there slid on frozen, all heat moving"
    ),
    "slide_contact_fraction": SlideCurve("1", False, "A/A0"),
    "slide_stress_correlation": SlideCurve(
        "1", False, "of the stress with the stress at positions so much earlier"
    ),
    "slide_spot_survival": SlideCurve(
        "1", False, "share of the contact spots that live for longer than that"
    ),
}
UNITS = {name: record.unit for name, record in OBSERVABLES.items()}


def stored_numbers(measured: Measured) -> dict[str, Array]:
    """Return the numbers that a member of single contacts stores, (speeds,) or (1,)."""
    missing = {
        DISTRIBUTION: measured.distribution is None,
        CAMERA: measured.seen_99 is None,
        _IN_DIRECTIONS: measured.seen_correlations is None,
    }
    return {
        name: one.of_member(measured)
        for name, one in NUMBERS.items()
        if not (one.of_slide or missing.get(one.asked, False))
    }


def quantiles_of(distribution: Distribution, prefix: str = "") -> dict[str, Array]:
    """Return the quantiles of a distribution, (speeds,), by their names; slides store them with "sliding_" before."""
    return {
        prefix + quantile(name, weight).name: getattr(distribution, f"by_{weight}")[:, place]
        for weight in ("heat", "area")
        for place, name in enumerate(LEVELS)
    }


def observables_of(asks: Container[str] = ()) -> dict[str, Observable]:
    """Return the observables of a scene that asks for these, or for nothing, as `Scene.asks`."""
    return {
        name: record
        for name, record in OBSERVABLES.items()
        if not record.asked or record.asked in asks
    }


for name, count in Counter(record.name for record in TABLE).items():
    if count > 1:
        raise ValueError(
            f"the observable {name!r} is defined twice; rename the one of your package"
        )
