"""T_flash beyond the cut-offs by the calibrated law: of faces with a lay with the modulus of all waves."""

import numpy as np

import roughsim as rs
import theory
from roughsim import prediction
from roughsim.surface.spectrum import TruncatedSpectrum

STEEL = {"youngs_modulus": 2e11, "poisson_ratio": 0.3, "conductivity": 45.0}
STEEL |= {"density": 7800.0, "heat_capacity": 450.0}


def test_a_lay_has_the_modulus_of_the_contact_of_all_waves():
    face = {"hurst": 0.8, "q_min": 1e4, "q_max": 1.6e5, "rms_slope": 0.1}
    face |= {"lay": 6.0, "lay_direction": "20 deg"}
    sliding = {"nominal_pressure": 4e9, "friction_coefficient": 0.2, "speed": [10.0]}
    sliding["direction"] = "50 deg"
    scene = rs.load_scene({"surface": face, "body": STEEL, "sliding": sliding})
    modulus, cut_offs = scene.effective_modulus, (4e4, 8e4)

    def up_to(end, stiffer):
        cut = TruncatedSpectrum(scene.spectrum, end)
        return theory.yielding.elastic_steps(
            cut, effective_modulus=stiffer * modulus, nominal_pressure=4e9, step=0.2
        )

    light, full = (6**0.5 + 6**-0.5) / 2, ((6 + 1 / 6) / 2) ** 0.5
    stiffer = light
    for _ in range(4):
        share = up_to(1.6e5, stiffer).contact_fraction
        stiffer = light + (full - light) * np.sin(np.pi / 2 * share)
    assert 0.2 < share < 0.8
    exact = [
        theory.lay.flash_temperature(
            10.0,
            np.pi / 6,
            theory.lay.LayStress(up_to(end, stiffer), 6.0, modulus),
            nominal_pressure=4e9,
            friction_coefficient=0.2,
            conductivity=45.0,
            diffusivity=45.0 / 7800.0 / 450.0,
        )
        for end in (*cut_offs, 1.6e5)
    ]
    found = prediction.calibrated_flash(scene, "elastic", cut_offs)
    np.testing.assert_allclose(found[:, 0], exact, rtol=1e-4)
