"""Warnings of numbers that are most likely a slip: of a unit, a factor of 2π, or a temperature scale."""

from collections.abc import Iterator
from math import inf, isinf, nextafter, pi, sqrt
from typing import NamedTuple

from roughsim.scene.faces import Faces
from roughsim.scene.sections import BodySection, CounterfaceSection, SlidingSection
from roughsim.scene.tables import values_of
from roughsim.show.remarks import Remark

STEEP = 0.5  # rms slope: the model is for small slopes


class _Usual(NamedTuple):
    """Usual numbers of a quantity, SI, and what is to be said of others."""

    low: float
    high: float
    unit: str
    advice: str


_ITS_UNIT = "the range of solids; check its unit"
_USUAL = {
    "rms height": _Usual(0.1e-9, inf, " m", "less than an atom; check the units of the roughness"),
    "shortest wave": _Usual(
        0.3e-9,
        inf,
        " m",
        "the distance of atoms, and the model is for continuous solids; check the unit of q_max, or lower it",
    ),
    "longest wave": _Usual(
        0.0,
        0.1,
        " m",
        'and that is shape, not roughness; check the units: q in rad/m (1/µm is 1e6 1/m: "0.1 1/um" or 1e5), and C(q) '
        "in m⁴ (µm⁴ is 1e-24 m⁴)",
    ),
    "longest wave of a scan": _Usual(
        0.0, 0.1, " m", "and that is shape, not roughness; check topography_size and its unit"
    ),
    "temperature": _Usual(
        200.0,
        inf,
        " K",
        'and temperatures are absolute; check its unit: if it is in °C, write "{:g} degC"',
    ),
    # from gels and aerogel to diamond, osmium and lithium
    "youngs_modulus": _Usual(1e3, 2e12, " Pa", _ITS_UNIT),
    "density": _Usual(20.0, 2.3e4, " kg/m³", _ITS_UNIT),
    "heat_capacity": _Usual(50.0, 6e3, " J/(kg K)", _ITS_UNIT),
    "conductivity": _Usual(0.01, 3e3, " W/(m K)", _ITS_UNIT),
    "diffusivity": _Usual(
        3e-8,
        2e-3,
        " m²/s",
        "the range of solids; check the units of conductivity, density and heat_capacity",
    ),
    # three times the strength of a perfect crystal
    "strength": _Usual(0.0, 0.3, "", "and no crystal is stronger; check the units of both"),
    "hardness": _Usual(
        1e5,
        inf,
        " Pa",
        "and no solid is so soft; check its unit, and the units of youngs_modulus and nominal_pressure",
    ),
    "fraction of the speed of shear waves": _Usual(
        0.0,
        0.5,
        "",
        "and in the model contact forms at once; check the units of speed, youngs_modulus and density",
    ),
    "friction": _Usual(nextafter(1e-3, 1.0), 5.0, "", "the range of dry solids; check it"),
}


def steepness(slope: float, advice: str = "check the units of the roughness") -> Iterator[Remark]:
    """Yield a warning of an rms slope that is not small."""
    if slope > STEEP:
        together = f"rms slope = {slope:.3g} of both faces together is above {STEEP:g}"
        text = f"{together}: the model is for small slopes; {advice}"
        yield Remark("limit", "rms slope", text)


def slips(scene: Faces) -> Iterator[Remark]:
    """Yield a warning for each number that is probably a mistake, with its value, the limit and the keys to check."""
    numbers = [*_of_roughness(scene), *_of_sliding(scene.sliding)]
    for name, body in scene.sections_of_bodies.items():
        numbers += _of_body(name, body, max(scene.sliding.speed))
    for kind, quantity, value in numbers:
        if not _is_usual(kind, value):
            low, high, unit, advice = _USUAL[kind]
            limits = f"above {high:g}" if low == 0.0 else f"not within {low:g} to {high:g}"
            if isinf(high):
                limits = f"below {low:g}"
            text = f"{quantity} = {value:.3g}{unit} is {limits}{unit}, {advice.format(value)}"
            yield Remark("slip", quantity, text)
    if 0.0 in scene.sliding.speed:
        yield Remark(
            "limit",
            "sliding.speed",
            "sliding.speed = 0 m/s: nothing slides, so that friction makes no heat and T_flash is 0; widths and shares "
            "of heat there are limits at rest; check its unit, or leave this speed out",
        )


_Numbers = Iterator[
    tuple[str, str, float]
]  # keys of `_USUAL`, keys of the scene or names, and values in SI


def _is_usual(kind: str, value: float) -> bool:
    """Return whether a number is within the usual ones of a kind."""
    return _USUAL[kind].low <= value <= _USUAL[kind].high


def _of_roughness(scene: Faces) -> _Numbers:
    """Yield the heights and the wavelengths of both faces together."""
    spectrum = scene.spectrum
    yield "rms height", "rms height of both faces together", spectrum.rms_height
    yield "shortest wave", "the shortest wave, 2π/q_max", 2 * pi / spectrum.breaks[-1]
    longest = "longest wave of a scan" if scene.scanned else "longest wave"
    yield longest, "the longest wave, 2π/q_min", 2 * pi / spectrum.breaks[0]


def _of_sliding(sliding: SlidingSection) -> _Numbers:
    """Yield friction and temperatures."""
    for friction in values_of(sliding.friction_coefficient):
        yield "friction", "sliding.friction_coefficient", friction
    if isinstance(sliding.friction_coefficient, tuple):
        coldest = sliding.friction_coefficient[0][0]
        yield "temperature", "sliding.friction_coefficient.temperature", coldest
    if sliding.background_temperature is not None:
        yield "temperature", "sliding.background_temperature", sliding.background_temperature


def _of_temperatures(name: str, body: BodySection | CounterfaceSection) -> _Numbers:
    """Yield the absolute temperatures of a body."""
    if isinstance(body.conductivity, tuple):
        yield "temperature", f"{name}.conductivity.temperature", body.conductivity[0][0]
    for key in ("melting_temperature", "temperature"):
        kelvin = getattr(body, key)
        if kelvin is not None:
            yield "temperature", f"{name}.{key}", kelvin


def _of_body(name: str, body: BodySection | CounterfaceSection, speed: float) -> _Numbers:
    """Yield the properties of a body, and D = κ/(ρc) and the speed of shear waves, √(G/ρ), if all others are usual."""
    usual = True
    for kind in ("youngs_modulus", "density", "heat_capacity", "conductivity"):
        for value in values_of(getattr(body, kind)):
            yield kind, f"{name}.{kind}", value
            usual &= _is_usual(kind, value)
    if usual and body.density and body.heat_capacity:
        for kappa in values_of(body.conductivity):
            yield "diffusivity", f"{name}.diffusivity", kappa / (body.density * body.heat_capacity)
    yield from _of_temperatures(name, body)
    hardness, modulus = body.penetration_hardness, body.youngs_modulus
    if hardness is not None:
        yield "hardness", f"{name}.penetration_hardness", hardness
    if hardness is not None and modulus is not None:
        yield "strength", f"{name}.penetration_hardness/youngs_modulus", hardness / modulus
    if modulus is not None and body.poisson_ratio is not None and body.density is not None:
        waves = sqrt(modulus / (2.0 * (1.0 + body.poisson_ratio)) / body.density)
        fast = "fraction of the speed of shear waves"
        yield fast, f"sliding.speed over the speed of shear waves in the {name}", speed / waves
