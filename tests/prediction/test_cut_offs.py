"""T_flash beyond the cut-offs by the calibrated law: each wave of a face with a lay has the modulus of its contact."""

import numpy as np
import pytest
from scipy.special import erf

import roughsim as rs
import theory
from roughsim import prediction
from roughsim.surface.spectrum import TruncatedSpectrum

STEEL = {"youngs_modulus": 2e11, "poisson_ratio": 0.3, "conductivity": 45.0}
STEEL |= {"density": 7800.0, "heat_capacity": 450.0}
HEAT = {"friction_coefficient": 0.2, "conductivity": 45.0, "diffusivity": 45.0 / 7800.0 / 450.0}
LAY, LOAD, HARDNESS, CUT_OFFS, END = 6.0, 4e9, 1.2e10, (4e4, 8e4), 1.6e5


def stiffening(elastic):
    light, full = (LAY**0.5 + LAY**-0.5) / 2, ((LAY + 1 / LAY) / 2) ** 0.5
    return light + (full - light) * np.sin(np.pi / 2 * elastic)


def elastic_area(variance):
    """Return A_el/A₀ = erf(σ₀/2√G)."""
    return erf(LOAD / (2 * np.sqrt(variance)))


def between_walls(variance):
    """Return A_el/A₀ of the pressure that diffused from σ₀ between walls at 0 and σ_P, by its modes."""
    modes = np.pi * np.arange(1, 400, 2)
    fading = np.exp(-np.multiply.outer(np.asarray(variance) / HARDNESS**2, modes**2))
    return fading @ (4 / modes * np.sin(modes * LOAD / HARDNESS))


class Stiffened:
    """C ~ q^−3.6 times [E_eff(q)/E_eff(q_max)]², with A_el/A₀ of the waves up to q."""

    def __init__(self, spectrum, modulus, area):
        self.spectrum, self.breaks, self.modulus = spectrum, (1e4, END), modulus
        self.area = area

    def __call__(self, q):
        return self.spectrum(q) * (self.factor(q) / self.factor(END)) ** 2

    def factor(self, q):
        integral = self.spectrum(1e4) * 1e4**3.6 * (np.asarray(q) ** 0.4 - 1e4**0.4) / 0.4
        return stiffening(self.area(np.pi / 4 * self.modulus**2 * np.maximum(integral, 1e-10)))


@pytest.mark.parametrize(
    ("slope", "hardness", "area", "law_of"),
    [
        (0.1, {}, elastic_area, theory.yielding.elastic_steps),
        (
            1.0,
            {"penetration_hardness": HARDNESS},
            between_walls,
            theory.plasticity.stress_spectrum,
        ),
    ],
)
def test_each_wave_of_a_lay_has_the_modulus_of_its_contact(slope, hardness, area, law_of):
    face = {"hurst": 0.8, "q_min": 1e4, "q_max": END, "rms_slope": slope}
    face |= {"lay": LAY, "lay_direction": "20 deg"}
    sliding = {"nominal_pressure": LOAD, "friction_coefficient": 0.2, "speed": [10.0]}
    sliding["direction"] = "50 deg"
    scene = rs.load_scene({"surface": face, "body": STEEL | hardness, "sliding": sliding})
    modulus = scene.effective_modulus

    def law(spectrum, end, stiffer):
        cut = TruncatedSpectrum(spectrum, end)
        return law_of(cut, effective_modulus=stiffer * modulus, nominal_pressure=LOAD, **hardness)

    stiffer = stiffening(0.0)
    for _ in range(4):
        stiffer = stiffening(law(scene.spectrum, END, stiffer).between_walls()[0])
    assert stiffer < 0.98 * stiffening(1.0)
    spectrum = Stiffened(scene.spectrum, stiffer * modulus, area)
    exact = []
    for end in (*CUT_OFFS, END):
        stress = theory.lay.LayStress(law(spectrum, end, stiffer), LAY, modulus)
        load = {"nominal_pressure": LOAD}
        exact.append(theory.lay.flash_temperature(10.0, np.pi / 6, stress, **load, **HEAT))
    found = prediction.calibrated_flash(scene, "capped" if hardness else "elastic", CUT_OFFS)
    np.testing.assert_allclose(found[:, 0], exact, rtol=1e-4)


def test_yielded_contact_goes_on_by_the_law_of_its_hardness():
    face = {"hurst": 0.8, "q_min": 1e4, "q_max": END, "rms_slope": 0.3}
    sliding = {"nominal_pressure": 1e8, "friction_coefficient": 0.2, "speed": [10.0]}
    body = STEEL | {"penetration_hardness": 1.2e9}
    scene = rs.load_scene({"surface": face, "body": body, "sliding": sliding})
    solid = {"nominal_pressure": 1e8}
    exact = []
    for end in (*CUT_OFFS, END):
        stress = theory.plasticity.stress_spectrum(
            TruncatedSpectrum(scene.spectrum, end),
            effective_modulus=scene.effective_modulus,
            penetration_hardness=1.2e9,
            **solid,
        )
        exact.append(theory.flash.flash_temperature(10.0, stress_spectrum=stress, **solid, **HEAT))
    found = prediction.calibrated_flash(scene, "capped", CUT_OFFS)
    assert found[:, 0] == pytest.approx(exact, rel=1e-9)
