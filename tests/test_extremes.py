"""Numbers of any size in every public stage and function of theory: a finite result, or one sentence that names them.

They run in a process of their own with a time limit: no number may keep it busy for ever.
"""

import re
import subprocess
import sys
from threading import Timer

import numpy as np
import pytest
from process_cases import begin_process

import roughsim as rs

SIZES = (1e-300, 1e-160, 1e-100, 1e-30, 1e30, 1e40, 1e100, 1e160, 1e300)
HEAT = {"speed": 1.0, "conductivity": 30.0, "diffusivity": 1e-5}
BODY = "rs.Body(conductivity, diffusivity, speed), rs.Body(20.0, 1e-5)"
LOAD = {"modulus": 1e11, "pressure": 1e8}
WHOLE = "effective_modulus=modulus, nominal_pressure=pressure"
YIELDS = WHOLE + ", penetration_hardness=hardness"
FLASH = (
    WHOLE + ", friction_coefficient=friction, conductivity=conductivity, diffusivity=diffusivity"
)
RUBBED = "rs.HeatSource([speed], friction, conductivity, diffusivity"
# what is computed, and its numbers; `flux`, `heights`, `cell`, `spectrum` are those of PREAMBLE
CASES = {
    "steady periodic": ("rs.sliding_temperature(flux, cell, slid_distance=np.inf, **heat)", HEAT),
    "periodic over time": (
        "rs.sliding_temperature(flux, cell, time=time, depth=depth, **heat)",
        HEAT | {"time": 1e-3, "depth": 1e-5},
    ),
    "periodic over a distance": (
        "rs.sliding_temperature(flux, cell, slid_distance=slid, **heat)",
        HEAT | {"slid": 1e-3},
    ),
    "half-space": ("rs.half_space_temperature(flux, cell, **heat)", HEAT),
    "half-space over time": (
        "rs.half_space_temperature(flux, cell, time=time, depth=depth, **heat)",
        HEAT | {"time": 1e-3, "depth": 1e-5},
    ),
    "source": (
        "astuple(source_temperature(flux, cell, time=time, **heat))[:3]",
        HEAT | {"time": 1e-3},
    ),
    "uniform": (
        "uniform_temperature(mean, time, conductivity=conductivity, diffusivity=diffusivity, depth=depth)",
        {"mean": 1e6, "conductivity": 30.0, "diffusivity": 1e-5, "time": 1e-3, "depth": 1e-5},
    ),
    "partition": (
        "(lambda m, r: rs.partition_heat(flux, cell, moving=m, resting=r, pointwise=False, time=time).temperature)"
        f"({BODY})",
        HEAT | {"time": 1e-3},
    ),
    "flux": (
        "rs.half_space_temperature(flux * level, cell, speed=1.0, conductivity=30.0, diffusivity=1e-5)",
        {"level": 1.0},
    ),
    "cell, half-space": (
        "rs.half_space_temperature(flux, rs.Grid(flux.shape, (along, across)), speed=1.0, conductivity=30.0, "
        "diffusivity=1e-5)",
        {"along": 1e-3, "across": 1e-3},
    ),
    "cell, periodic": (
        "rs.sliding_temperature(flux, rs.Grid(flux.shape, (along, across)), speed=1.0, conductivity=30.0, "
        "diffusivity=1e-5)",
        {"along": 1e-3, "across": 1e-3},
    ),
    "capped contact": (
        "rs.solve_contact(heights * level, cell, rs.Solid(modulus, hardness), nominal_pressure=pressure).pressure",
        LOAD | {"level": 1e-6, "hardness": 1e9},
    ),
    "elastic contact": (
        "rs.solve_contact(heights * level, cell, rs.Solid(modulus), nominal_pressure=pressure).pressure",
        LOAD | {"level": 1e-6},
    ),
    "cell, contact": (
        "rs.solve_contact(heights * 1e-6, rs.Grid(heights.shape, (along, across)), rs.Solid(1e11, 1e9), "
        "nominal_pressure=1e8).pressure",
        {"along": 1e-3, "across": 1e-3},
    ),
    "measured": (f"of_moments(rs.measure(contact(), cell, {RUBBED})))", HEAT | {"friction": 0.1}),
    "measured along a direction": (
        f"of_moments(rs.measure(contact(), cell, {RUBBED}, direction=0.3)))",
        HEAT | {"friction": 0.1},
    ),
    "surface": (
        "rs.synthesize(rs.SelfAffineSpectrum.from_rms_height(level, hurst=0.8, q_min=low, q_max=high), cell, "
        "np.random.default_rng(0))",
        {"level": 1e-6, "low": 7e3, "high": 4e4},
    ),
    "slide": (
        "rs.slide(heights * level, cell, rs.Solid(1e11, 1e9), nominal_pressure=1e8, friction_coefficient=friction, "
        "speed=speed, moving=rs.Body(conductivity, diffusivity, speed), resting=rs.Body(30.0, 1e-5), "
        "slid_distance=slid, steps=3).flash_temperature",
        HEAT | {"level": 1e-6, "friction": 0.1, "slid": 2e-4},
    ),
    "theory": (
        f"flash.flash_temperature(speed, spectrum, {FLASH})",
        LOAD | HEAT | {"friction": 0.1},
    ),
    "theory, gradient": (
        f"flash.flash_gradient(speed, spectrum, {FLASH})",
        LOAD | HEAT | {"friction": 0.1},
    ),
    "theory, Laplacian": (
        f"flash.flash_laplacian(speed, spectrum, {FLASH})",
        LOAD | HEAT | {"friction": 0.1},
    ),
    "smoothed": (
        f"plasticity.smoothed_spectrum(spectrum, {YIELDS})(1e4)",
        LOAD | {"hardness": 1e9},
    ),
    "law of yielding": (
        f"plasticity.stress_spectrum(spectrum, {YIELDS})(1e4)",
        LOAD | {"hardness": 1e9},
    ),
    "elastic law": (f"persson.calibrated_spectrum(spectrum, {WHOLE})(1e4)", LOAD),
    "correlation": (f"persson.pressure_correlation(r, spectrum, {WHOLE})", LOAD | {"r": 1e-5}),
    "contact fraction": (f"persson.contact_probability(2e4, spectrum, {WHOLE})", LOAD),
    "areas": (
        "plasticity.area_fractions(variance, pressure, hardness)",
        {"variance": 1e16, "pressure": 1e8, "hardness": 1e9},
    ),
    "Hertz": (
        "[f(peclet) for f in (hertz.flash_temperature, hertz.max_temperature, hertz.mean_temperature)]",
        {"peclet": 1.0},
    ),
}
PREAMBLE = """
import sys, warnings
from dataclasses import astuple
import numpy as np
import roughsim as rs
from roughsim.heat import source_temperature, uniform_temperature
from theory import flash, hertz, persson, plasticity

warnings.simplefilter("ignore")
cell = rs.Grid((16, 16), (1e-3, 1e-3))
flux = np.zeros(cell.shape)
flux[4:8, 4:8] = 1e9
heights = np.random.default_rng(0).standard_normal(cell.shape)
spectrum = rs.SelfAffineSpectrum.from_rms_height(1e-6, hurst=0.8, q_min=6e3, q_roll_off=3e4, q_max=1e6)

def contact():
    return rs.solve_contact(heights * 1e-6, cell, rs.Solid(1e11, 1e9), nominal_pressure=1e8)

def of_moments(moments):
    return [moments.flash_temperature, moments.flash_gradient, moments.flash_laplacian]

def of(text, numbers):
    heat = {key: numbers[key] for key in ("speed", "conductivity", "diffusivity") if key in numbers}
    names = globals() | numbers | {"heat": heat}
    try:
        result = np.asarray(eval(text, names), float)
    except (ValueError, rs.ConvergenceError) as error:
        return "refused: " + str(error)
    except Exception as error:
        return f"wrong: {type(error).__name__} {error}"
    return "finite" if np.isfinite(result).all() else "wrong: not finite"
"""
NAMED = re.compile(
    "lengths|speed|diffusivity|conductivity|temperature|pressure|heights|modulus|hardness|rms_height|q_min|q_roll_off|"
    "q_max|friction|slid_distance|spectrum|heat_flux|pixel|contact solve|time|bodies|steps|variance"
)


TRIES = [
    (name, key, size)
    for name, (_, numbers) in CASES.items()
    for key, size in [(None, 0.0), *((key, size) for key in numbers for size in SIZES)]
]


@pytest.fixture(scope="module")
def answers():
    """The answers to all tries, by their cases; of one that never ends, and of later ones, there are none."""
    code = f"""{PREAMBLE}
cases = {CASES!r}
for name, key, size in {TRIES!r}:
    text, numbers = cases[name]
    print(of(text, numbers | ({{key: size}} if key else {{}})), flush=True)
"""
    with begin_process([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        ender = Timer(240.0, process.kill)
        ender.start()
        said = process.stdout.read().splitlines()
        ender.cancel()
    result = {name: {} for name in CASES}
    for (name, key, size), answer in zip(TRIES, said, strict=False):
        result[name][key, size] = answer
    return result


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_a_number_of_any_size_gives_a_finite_result_or_is_refused_by_name(answers, name):
    assert list(answers[name]) == [(key, size) for other, key, size in TRIES if other == name]
    assert answers[name][None, 0.0] == "finite"
    for (key, size), answer in answers[name].items():
        assert answer == "finite" or (answer.startswith("refused") and NAMED.search(answer)), (
            key,
            size,
            answer,
        )


def test_the_highest_peclet_number_is_computed_and_falls_as_the_fast_limit():
    # κT ~ (D/v)^½, until no quadrature follows: a hundred times the speed is a tenth of the temperature
    grid, flux = rs.Grid((16, 16), (1e-3, 1e-3)), np.zeros((16, 16))
    flux[4:8, 4:8] = 1e9
    hot = [
        rs.half_space_temperature(flux, grid, speed=v, conductivity=30.0, diffusivity=1e-5).max()
        for v in (1e16, 1e18)
    ]
    assert hot[0] / hot[1] == pytest.approx(10.0, rel=1e-3)
    with pytest.raises(
        ValueError,
        match=r"speed = 1e\+19 m/s .* the Péclet number v L/D = 1e\+21 of a cell of 0\.001 m",
    ):
        rs.half_space_temperature(flux, grid, speed=1e19, conductivity=30.0, diffusivity=1e-5)


def test_heights_beyond_double_precision_are_refused_and_not_pressed_flat():
    grid = rs.Grid((16, 16), (1e-3, 1e-3))
    heights = np.random.default_rng(0).standard_normal(grid.shape)
    for level in (1e297, 1e300, 1e307):
        with pytest.raises(
            ValueError, match="nominal_pressure = 1e\\+08 Pa is .* check the units of the heights"
        ):
            rs.solve_contact(heights * level, grid, rs.Solid(1e11, 1e9), nominal_pressure=1e8)
