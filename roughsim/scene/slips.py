"""Warnings of numbers that are most likely a slip: of a unit, a factor of 2π, or a temperature scale."""

from collections.abc import Iterator, Mapping
from math import inf, pi, sqrt

from roughsim.scene.sections import BodySection, CounterfaceSection, SlidingSection
from roughsim.show.remarks import Remark
from roughsim.surface.spectrum import Face, SumSpectrum

_LONGEST = 0.1  # m: longer waves are shape, not roughness
_COLDEST = 200.0  # K: below, a temperature is most likely one in °C
_SOFTEST = 1e5  # Pa, hardness: of gels
_ATOM = 0.3e-9  # m: shorter waves are no continuum
_FLAT = 0.1e-9  # m, rms height: a layer of atoms alone is rougher
_STRONGEST = 0.3  # hardness over Young's modulus: three times the strength of a perfect crystal
_FAST = 0.5  # of the speed of shear waves: in the model contact forms at once
_FRICTION = 1e-3, 5.0  # of dry solids
STEEP = 0.5  # rms slope: the model is for small slopes
# the range of solids, SI, from gels and aerogel to diamond, osmium and lithium
_USUAL = {
    "youngs_modulus": (1e3, 2e12, "Pa"),
    "density": (20.0, 2.3e4, "kg/m³"),
    "heat_capacity": (50.0, 6e3, "J/(kg K)"),
    "conductivity": (0.01, 3e3, "W/(m K)"),
    "diffusivity": (3e-8, 2e-3, "m²/s"),
}


def steepness(slope: float, advice: str = "check the units of the roughness") -> Iterator[Remark]:
    """Yield a warning of an rms slope that is not small."""
    if slope > STEEP:
        together = f"rms slope = {slope:.3g} of both faces together is above {STEEP:g}"
        text = f"{together}: the model is for small slopes; {advice}"
        yield Remark("limit", "rms slope", text)


def slips(
    spectrum: Face | SumSpectrum,
    scanned: bool,
    bodies: Mapping[str, BodySection | CounterfaceSection],
    sliding: SlidingSection,
) -> Iterator[Remark]:
    """Yield a warning for each number that is probably a mistake, with its value, the limit and the keys to check.

    `spectrum` is the composite C(q), which is `scanned` if it was measured; the bodies are by their sections.
    """
    yield from _slips_of_roughness(spectrum, scanned)
    for key, kelvin in _temperatures(bodies, sliding):
        if kelvin < _COLDEST:
            yield Remark(
                "slip",
                key,
                f"{key} = {kelvin:g} K is below {_COLDEST:g} K, and temperatures are absolute; check its unit: "
                f'if it is in °C, write "{kelvin:g} degC"',
            )
    for name, body in bodies.items():
        yield from _slips_of_body(name, body, max(sliding.speed))
    yield from _slips_of_sliding(sliding)


def _slips_of_roughness(spectrum: Face | SumSpectrum, scanned: bool) -> Iterator[Remark]:
    """Yield warnings of the heights and the wavelengths of both faces together."""
    height, ends = spectrum.rms_height, spectrum.breaks
    longest, shortest = 2 * pi / ends[0], 2 * pi / ends[-1]
    if height < _FLAT:
        yield Remark(
            "slip",
            "rms height",
            f"rms height = {height:.3g} m of both faces together is below {_FLAT:g} m, less than an atom; "
            "check the units of the roughness",
        )
    if shortest < _ATOM:
        yield Remark(
            "slip",
            "shortest wave",
            f"the shortest wave, 2π/q_max = {shortest:.3g} m, is below {_ATOM:g} m, the distance of atoms, "
            "and the model is for continuous solids; check the unit of q_max, or lower it",
        )
    if longest > _LONGEST:
        units = 'the units: q in rad/m (1/µm is 1e6 1/m: "0.1 1/um" or 1e5), and C(q) in m⁴ (µm⁴ is 1e-24 m⁴)'
        yield Remark(
            "slip",
            "longest wave",
            f"the longest wave, 2π/q_min = {longest:.3g} m, is above {_LONGEST:g} m, and that is shape, not roughness; "
            f"check {'topography_size and its unit' if scanned else units}",
        )


def _slips_of_sliding(sliding: SlidingSection) -> Iterator[Remark]:
    """Yield warnings of the friction and the speeds."""
    given = sliding.friction_coefficient
    values = [row[1] for row in given] if isinstance(given, tuple) else [given]
    strange = [value for value in values if not _FRICTION[0] < value <= _FRICTION[1]]
    if strange:
        yield Remark(
            "slip",
            "sliding.friction_coefficient",
            f"sliding.friction_coefficient = {strange[0]:.3g} is not within {_FRICTION[0]:g} to {_FRICTION[1]:g}, the "
            "range of dry solids; check it",
        )
    if 0.0 in sliding.speed:
        yield Remark(
            "limit",
            "sliding.speed",
            "sliding.speed = 0 m/s: nothing slides, so that friction makes no heat and T_flash is 0; widths and shares "
            "of heat there are limits at rest; check its unit, or leave this speed out",
        )


def _temperatures(
    bodies: Mapping[str, BodySection | CounterfaceSection], sliding: SlidingSection
) -> Iterator[tuple[str, float]]:
    """Yield each absolute temperature of a scene with its key, K; of a table the lowest."""
    if sliding.background_temperature is not None:
        yield "sliding.background_temperature", sliding.background_temperature
    for name, body in bodies.items():
        if body.melting_temperature is not None:
            yield f"{name}.melting_temperature", body.melting_temperature
        if isinstance(body.conductivity, tuple):
            yield f"{name}.conductivity.temperature", body.conductivity[0][0]
    if isinstance(sliding.friction_coefficient, tuple):
        yield "sliding.friction_coefficient.temperature", sliding.friction_coefficient[0][0]


def _slips_of_body(
    name: str, body: BodySection | CounterfaceSection, speed: float
) -> Iterator[Remark]:
    """Yield a warning for each property that no solid has, and for sliding as fast as sound."""
    for quantity, value in _properties(body):
        low, high, unit = _USUAL[quantity]
        if not low <= value <= high:
            units = (
                "its unit"
                if quantity != "diffusivity"
                else "the units of conductivity, density and heat_capacity"
            )
            yield Remark(
                "slip",
                f"{name}.{quantity}",
                f"{name}.{quantity} = {value:.3g} {unit} is not within {low:g} to {high:g} {unit}, the range of "
                f"solids; check {units}",
            )
    hardness, modulus = body.penetration_hardness, body.youngs_modulus
    if hardness is not None and modulus is not None and hardness > _STRONGEST * modulus:
        yield Remark(
            "slip",
            f"{name}.penetration_hardness/youngs_modulus",
            f"{name}.penetration_hardness = {hardness:.3g} Pa is above {_STRONGEST:g} of youngs_modulus = "
            f"{modulus:.3g} Pa, and no crystal is stronger; check the units of both",
        )
    if hardness is not None and hardness < _SOFTEST:
        yield Remark(
            "slip",
            f"{name}.penetration_hardness",
            f"{name}.penetration_hardness = {hardness:.3g} Pa is below {_SOFTEST:g} Pa, and no solid is so soft; check "
            "its unit, and the units of youngs_modulus and nominal_pressure",
        )
    waves = inf  # speed of shear waves, √(G/ρ)
    if modulus is not None and body.poisson_ratio is not None and body.density is not None:
        waves = sqrt(modulus / (2.0 * (1.0 + body.poisson_ratio)) / body.density)
    if speed > _FAST * waves:
        yield Remark(
            "slip",
            f"sliding.speed/shear waves of {name}",
            f"sliding.speed = {speed:.3g} m/s is above {_FAST:g} of the speed of shear waves in the {name}, "
            f"{waves:.3g} m/s: in the model contact forms at once; check the units of speed, youngs_modulus and "
            "density",
        )


def _properties(body: BodySection | CounterfaceSection) -> Iterator[tuple[str, float]]:
    """Yield properties of a body, κ at each temperature of a table, and D = κ/(ρc) if all others are usual."""
    strange = False
    for name in ("youngs_modulus", "density", "heat_capacity", "conductivity"):
        stated = getattr(body, name)
        for value in (
            [row[1] for row in stated]
            if isinstance(stated, tuple)
            else [stated] * (stated is not None)
        ):
            strange |= not _USUAL[name][0] <= value <= _USUAL[name][1]
            yield name, value
            if name == "conductivity" and not strange and body.density and body.heat_capacity:
                yield "diffusivity", value / (body.density * body.heat_capacity)
