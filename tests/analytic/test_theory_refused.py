"""Theory: arguments without meaning are refused by name and value with unit, before any integral."""

from functools import partial
from math import inf, nan

import numpy as np
import pytest
from power_law import Flat, PowerLaw
from refused_cases import assert_refused

from theory import background, classical, flash, hardness, hertz, partition, persson, plasticity
from theory.quadrature import QuadratureError

BAND, UNIFORM = Flat(1.0, (1.0, 2.0)), Flat(0.0, (1.0, 2.0))
STRESS = {"nominal_pressure": 1.0, "stress_spectrum": BAND}
BODY = {"conductivity": 46.0, "diffusivity": 1.2e-5}
SLIDING = {**STRESS, **BODY, "friction_coefficient": 0.2}
SURFACE = PowerLaw(2e-27, (6e3, 2e4, 4e5), 0.7)
CONTACT = {"effective_modulus": 1.1e11, "nominal_pressure": 9e7}
OXIDE = (3e-6, 3.0, 9e-7)  # as warm as steel 5·√(2.8e-10 s·m²/s) below its surface

FLASH = {
    "speed holds values that are NaN": {"speed": nan},
    "speed holds .* infinite": {"speed": inf},
    "speed = 'fast'": {"speed": "fast"},
    "speed = 1j": {"speed": 1j},
    "friction_coefficient = 0 .*must be positive": {"friction_coefficient": 0.0},
    "conductivity = -1 W": {"conductivity": -1.0},
    "diffusivity = 0 m²/s must be positive": {"diffusivity": 0.0},
    "diffusivity holds .* infinite": {"diffusivity": inf},
    "nominal_pressure = 0 Pa must be positive": {"nominal_pressure": 0.0},
    "skin = .* must be thickness, conductivity and diffusivity": {"skin": (1e-6, 3.0)},
    "thickness of the skin = 0 m must be positive": {"skin": (0.0, 3.0, 1e-6)},
    r"conductivity of the skin = -3 W/\(m K\) must be positive": {"skin": (1e-6, -3.0, 1e-6)},
    "diffusivity of the skin holds values": {"skin": (1e-6, 3.0, nan)},
    "heat_depth = -1 m must not be negative": {"heat_depth": -1.0},
    "heat_depth has shape": {"heat_depth": [1.0]},
}
PERSSON = {
    "effective_modulus = -1 Pa must be positive": {"effective_modulus": -1.0},
    "effective_modulus is missing": {"effective_modulus": None},
    "nominal_pressure holds values that are NaN": {"nominal_pressure": nan},
    "nominal_pressure has shape": {"nominal_pressure": [1.0, 2.0]},
    r"gamma = 1\.5 must lie from 0 to 1": {"gamma": 1.5},
    "finite weights": {"gamma": lambda share, q: -share},
    r"spectrum = -1 at q = ": {"spectrum": Flat(-1.0, (1.0, 2.0))},
    "ascending": {"spectrum": Flat(1.0, (2.0, 1.0))},
    "positive wavenumbers": {"spectrum": Flat(1.0, (0.0, 1.0))},
    "enclose no wavenumbers": {"spectrum": Flat(1.0, (2.0, 2.0))},
    "breaks": {"spectrum": np.sin},
    "spectrum is missing": {"spectrum": None},
    "both given": {"stress_spectrum": BAND},
}
SHARE = {
    "rule = 'median'": {"rule": "median"},
    "duration is missing": {"rule": "total"},
    "duration = 0 s must be positive": {"rule": "total", "duration": 0.0},
    "does not enter the steady rule": {"duration": 1.0},
    "resting_conductivity = -1": {"resting_conductivity": -1.0},
    "resting_diffusivity": {"resting_diffusivity": inf},
    "speed": {"speed": nan},
    "duration: heat spreads .* less than 5 times the 1.*e-05 m of the skin": {
        "skin": OXIDE, "rule": "total", "duration": 1e-5
    },
}  # fmt: skip
BACKGROUND = {
    "t = -1 s": {"t": -1.0},
    "t holds values that are NaN": {"t": nan},
    "heat_flux = 0 W/m² must be positive": {"heat_flux": 0.0},
    "conductivity holds .* infinite": {"conductivity": inf},
    "diffusivity = -1 m²/s": {"diffusivity": -1.0},
    "less than 5 times the 1e-05 m of the skin or the heat_depth": {
        "t": 0.99 * 25 * 1e-10 / 1.2e-5, "heat_depth": 1e-5
    },
    "less than 5 times the 1.*e-05 m of the skin": {"t": 1e-5, "skin": OXIDE},
    "go with a constant heat_flux": {"heat_flux": lambda t: 1.0, "heat_depth": 1e-6},
    "heat_flux holds values": {"heat_flux": lambda t: nan},
    "breaks": {"heat_flux": lambda t: 1.0, "breaks": [-1.0]},
}  # fmt: skip
TABLES = {
    "background = 200 K lies outside": (([300.0, 800.0], [1.2e9, 0.8e9]), 200.0),
    "background": (([300.0, 800.0], [1.2e9, 0.8e9]), nan),
    "two or more rising": (([300.0], [1e9]), 300.0),
    "^.*two or more rising": (([300.0, 300.0], [1e9, 1e9]), 300.0),
    "two or more rising.*": (([300.0, 400.0], [1e9]), 300.0),
    "must not rise": (([300.0, 400.0], [1e9, 2e9]), 300.0),
    "must be positive": (([300.0, 400.0], [1e9, 0.0]), 300.0),
    "becomes hotter than the table": (([300.0, 400.0], [1e9, 1e9]), 300.0),
}
smoothed = partial(plasticity.smoothed_spectrum, SURFACE, **CONTACT)
yields = partial(plasticity.yield_wavenumber, SURFACE, penetration_hardness=1e9, **CONTACT)
correlation = partial(persson.pressure_correlation, stress_spectrum=BAND)
radius = partial(persson.correlation_radius, stress_spectrum=BAND)
OWN = {
    "peclet holds values": lambda: classical.jaeger(nan),
    "^peclet holds values": lambda: classical.archard(nan),
    "peclet holds ": lambda: classical.greenwood(nan),
    "^peclet holds": lambda: classical.tian_kennedy(nan),
    "peclet = 'fast'": lambda: classical.jaeger("fast"),
    "source = 'ring', quantity = 'flash' must be one of": lambda: classical.greenwood(
        1.0, source="ring"
    ),
    "quantity = 'flash' must be one of": lambda: classical.greenwood(
        1.0, source="disc", quantity="flash"
    ),
    "source = 'ring' must be one of": lambda: classical.tian_kennedy(1.0, source="ring"),
    "stress is uniform": lambda: flash.flash_width(1.0, **SLIDING | {"stress_spectrum": UNIFORM}),
    "^.*stress is uniform": lambda: flash.slope_length(
        1.0, **SLIDING | {"stress_spectrum": UNIFORM}
    ),
    r"speed has shape \(1,\); give one speed": lambda: flash.temperature_correlation(
        0.0, [1.0], **SLIDING
    ),
    "x holds": lambda: hertz.static_temperature(nan, 0.0),
    "^x holds": lambda: hertz.fast_temperature(nan, 0.0),
    "y =": lambda: hertz.static_temperature(0.0, None),
    "^y =": lambda: hertz.fast_temperature(0.0, None),
    "distance = -1 R": lambda: hertz.pressure_correlation(-1.0),
    "r = -1 m": lambda: correlation(-1.0),
    "r holds values that are NaN": lambda: correlation(nan),
    "r holds .* infinite": lambda: correlation(inf),
    "fraction = -0.1": lambda: radius(-0.1),
    "fraction = 1": lambda: radius(1.0),
    "fraction = 2": lambda: radius(2.0),
    "vanishes at every distance": lambda: persson.correlation_radius(0.5, stress_spectrum=UNIFORM),
    r"no wave of it is left.*C\(q\) is in m⁴, and 1 µm⁴ is 1e-24 m⁴": lambda: smoothed(
        effective_modulus=1e30, penetration_hardness=1e9
    ),
    r"nominal_pressure = 2e.09 Pa exceeds the penetration_hardness 1e.09 Pa": lambda: (
        plasticity.area_fractions(1.0, 2e9, 1e9)
    ),
    "half_variance = -1 Pa² must not be negative": lambda: plasticity.area_fractions(
        [-1.0], 1e8, 1e9
    ),
    "penetration_hardness = 0 Pa": lambda: smoothed(penetration_hardness=0.0),
    "penetration_hardness = -1 Pa": lambda: smoothed(penetration_hardness=-1.0),
    "penetration_hardness holds values that are NaN": lambda: smoothed(penetration_hardness=nan),
    "penetration_hardness holds .* infinite": lambda: smoothed(penetration_hardness=inf),
    "elastic_share = 0 ": lambda: yields(elastic_share=0.0),
    "elastic_share = 1 ": lambda: yields(elastic_share=1.0),
    "elastic_share": lambda: yields(elastic_share=nan),
    "stress = -1 Pa": lambda: plasticity.stress_distribution(-1.0, 1.0, 1.0, 2.0),
    "stress = 2.1 Pa exceeds the penetration_hardness 2 Pa": lambda: plasticity.stress_distribution(
        2.1, 1.0, 1.0, 2.0
    ),
    "half_variance = 0 Pa² must be positive": lambda: plasticity.stress_distribution(
        1.0, 0.0, 1.0, 2.0
    ),
    "nominal_pressure = 3 Pa exceeds": lambda: plasticity.stress_distribution(1.0, 1.0, 3.0, 2.0),
    "poisson_ratio = 0.51 must lie above −1 and be at most 0.5": lambda: persson.effective_modulus(
        2e11, 0.51
    ),
    "poisson_ratio = -1": lambda: persson.effective_modulus(2e11, -1.0),
    "poisson_ratio": lambda: persson.effective_modulus(2e11, nan),
    "youngs_modulus = 0 Pa must be positive": lambda: persson.effective_modulus(0.0, 0.3),
    "one or two numbers each": lambda: persson.effective_modulus([1e9, 1e9, 1e9], 0.3),
    "^.*one or two numbers each": lambda: persson.effective_modulus([1e9, 1e9], [0.3, 0.3, 0.3]),
    "^effective_modulus = -1 Pa": lambda: persson.calibrated_spectrum(
        SURFACE, effective_modulus=-1.0, nominal_pressure=1e9
    ),
    "^nominal_pressure holds values": lambda: persson.calibrated_spectrum(
        SURFACE, effective_modulus=1.1e11, nominal_pressure=nan
    ),
    "spectrum = 3.0 must be a callable": lambda: persson.calibrated_spectrum(3.0, **CONTACT),
}


@pytest.mark.parametrize(
    "function",
    [
        flash.flash_temperature,
        flash.flash_gradient,
        flash.flash_laplacian,
        flash.flash_width,
        flash.slope_length,
    ],
)
@pytest.mark.parametrize("words", FLASH)
def test_flash_refuses_by_name_and_value(function, words):
    assert_refused(lambda: function(**{"speed": 1.0, **SLIDING, **FLASH[words]}), words)


@pytest.mark.parametrize("words", PERSSON)
def test_persson_refuses_by_name_and_value(words):
    given = {"spectrum": BAND, "effective_modulus": 1.0, "nominal_pressure": 1.0} | PERSSON[words]
    assert_refused(lambda: persson.pressure_correlation(1.0, **given), words)


@pytest.mark.parametrize("words", SHARE)
def test_moving_share_refuses_by_name_and_value(words):
    given = {"speed": 1.0, **STRESS, **BODY, **SHARE[words]}
    assert_refused(lambda: partition.moving_share(**given), words)


@pytest.mark.parametrize("words", BACKGROUND)
def test_background_refuses_by_name_and_value(words):
    given = {"t": 1.0, "heat_flux": 1.0, **BODY, **BACKGROUND[words]}
    assert_refused(lambda: background.temperature(**given), words)


@pytest.mark.parametrize("words", TABLES)
def test_hardness_refuses_tables_without_meaning(words):
    table, start = TABLES[words]
    given = partial(hardness.self_consistent, lambda y: 1e-6 * y, *table, background=start)
    assert_refused(given, words)


@pytest.mark.parametrize("words", OWN)
def test_theory_refuses_by_name_and_value(words):
    assert_refused(OWN[words], words)


@pytest.mark.parametrize(
    "scale", [1e-9, *(pytest.param(x, marks=pytest.mark.slow) for x in (1.0, 1e9))]
)
def test_background_refuses_an_unresolved_flux(scale):
    draws = np.random.default_rng(1)
    for noisy in (
        lambda t: scale * np.sign(np.sin(1e9 * np.asarray(t))),
        lambda t: scale * draws.random(),
    ):
        with pytest.raises(QuadratureError, match="name the breaks"):
            background.temperature(0.4, heat_flux=noisy, **BODY)
