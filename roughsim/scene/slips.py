"""Numbers of a scene that are lawful and yet most likely a slip: of a unit, a factor of 2π, or a temperature scale."""

from collections.abc import Iterator
from math import pi

from roughsim.scene.model import Scene

LONGEST = 0.1  # m: longer waves are shape, not roughness
COLDEST = 200.0  # K: below, a temperature is most likely one in °C
SOFTEST = 1e5  # Pa, hardness: of gels


def slips(scene: Scene) -> Iterator[str]:
    """Yield a warning for each number that is most likely a slip, with its value, the limit and what to check."""
    longest = 2 * pi / scene.spectrum.breaks[0]
    if longest > LONGEST:
        yield (
            f"the longest wave, 2π/q_min = {longest:.3g} m, is above {LONGEST:g} m, and that is shape, not roughness; "
            'check the units: q in rad/m, where 1/µm is 1e6 1/m ("0.1 1/um" or 1e5), and C(q) in m⁴, where µm⁴ is 1e-24'
        )
    for key, kelvin in temperatures(scene):
        if kelvin < COLDEST:
            yield (
                f"{key} = {kelvin:g} K is below {COLDEST:g} K, and temperatures are absolute; check its unit: "
                f'if it is in °C, write "{kelvin:g} degC"'
            )
    for name, body in (("body", scene.body), ("counterface", scene.counterface)):
        if body is not None and body.penetration_hardness is not None and body.penetration_hardness < SOFTEST:
            yield (
                f"{name}.penetration_hardness = {body.penetration_hardness:.3g} Pa is below {SOFTEST:g} Pa, and no "
                "solid is so soft; check its unit, and those of youngs_modulus and nominal_pressure"
            )
    if 0.0 in scene.speeds:
        yield (
            "sliding.speed = 0 m/s: nothing slides, so that friction makes no heat and T_flash is 0; widths and shares "
            "of heat there are limits at rest; check its unit, or leave this speed out"
        )


def temperatures(scene: Scene) -> Iterator[tuple[str, float]]:
    """Yield each absolute temperature of a scene with its key, K; of a table the lowest."""
    if scene.sliding.background_temperature is not None:
        yield "sliding.background_temperature", scene.sliding.background_temperature
    for name, body in (("body", scene.body), ("counterface", scene.counterface)):
        if body is not None and body.melting_temperature is not None:
            yield f"{name}.melting_temperature", body.melting_temperature
        if body is not None and isinstance(body.conductivity, tuple):
            yield f"{name}.conductivity.temperature", body.conductivity[0][0]
    if isinstance(scene.sliding.friction_coefficient, tuple):
        yield "sliding.friction_coefficient.temperature", scene.sliding.friction_coefficient[0][0]
