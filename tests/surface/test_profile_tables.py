"""C(q) from the spectrum of profiles: closed forms, the order of its error, and scenes that give such tables."""

import numpy as np
import pytest
import scipy.integrate
import scipy.special

import roughsim as rs
from roughsim.scene import SceneError, parse_scene
from roughsim.surface.topography.profiles import of_profile_table

BODY = """
[body]
youngs_modulus = "200 GPa"
poisson_ratio = 0.3
penetration_hardness = "1.2 GPa"
conductivity = 30
density = 7900
heat_capacity = 500
[sliding]
nominal_pressure = "90 MPa"
friction_coefficient = 0.11
speed = "35 m/s"
"""


@pytest.mark.parametrize("exponent", [0.8, 1.6, 2.6, 3.5])
@pytest.mark.parametrize("rows", [4, 30])
def test_a_power_law_has_its_closed_form(exponent, rows):
    # C₁ = ∫ q^(−m) dp over all p = √π Γ((m − 1)/2)/Γ(m/2) k^(1 − m) with m = exponent + 1
    k, m = np.geomspace(1e3, 1e6, rows), exponent + 1
    ratio = np.sqrt(np.pi) * scipy.special.gamma((m - 1) / 2) / scipy.special.gamma(m / 2)
    psd, error = of_profile_table(k, 1e-9 * ratio * k**-exponent)
    # a power law beyond 30 times the last row is left out
    np.testing.assert_allclose(psd, 1e-9 * k**-m, rtol=30.0**-m + 1e-6)
    assert error[0] < 0.02
    assert error[-1] >= 0.99


def gaussian(rows):
    """Largest relative error of C = e^(−q²/2w²), whose profile has √(2π) w e^(−k²/2w²), up to 2 w; and the stated."""
    w = 1e5
    k = np.geomspace(1e3, 6e5, rows)
    psd, error = of_profile_table(k, np.sqrt(2 * np.pi) * w * np.exp(-((k / w) ** 2) / 2))
    inside = k < 2 * w
    deviation = np.abs(psd / np.exp(-((k / w) ** 2) / 2) - 1)[inside]
    assert (deviation <= 1.2 * error[inside] + 1e-6).all()
    return deviation.max()


def test_a_gaussian_is_met_with_its_order():
    # its exponent is off by the step, which counts at the root of the distance from q
    steps = np.array([40, 80, 160])
    order = np.polyfit(np.log(steps), np.log([gaussian(int(rows)) for rows in steps]), 1)[0]
    assert order == pytest.approx(-1.5, abs=0.1)


@pytest.mark.parametrize("rows", [20, 21, 40, 41])
def test_the_first_row_of_even_steps_is_within_its_error(rows):
    # the first of them is a factor of 16 to 33 wide, over which a Gaussian is no power law
    w, k = 1e5, np.linspace(1e3, 6e5, rows)
    psd, error = of_profile_table(k, np.sqrt(2 * np.pi) * w * np.exp(-((k / w) ** 2) / 2))
    assert abs(psd[0] - 1.0) < error[0]


def profile_of(law, q):
    """C₁ of lines across a surface by quadrature."""

    def along(x):
        kinks = [np.sqrt(max(edge**2 - x**2, 1e-9)) for edge in law.breaks]
        end = np.sqrt(law.breaks[-1] ** 2 - x**2)
        return (
            2
            * scipy.integrate.quad(
                lambda y: law(np.hypot(x, y)), 0, end, limit=400, points=kinks[:-1]
            )[0]
        )

    return np.array([along(x) for x in q])


LAW = rs.SelfAffineSpectrum.from_rms_height(
    0.9e-6, hurst=0.8, q_min=6350, q_roll_off=9.4e4, q_max=1e6
)
Q = np.geomspace(6350, 0.999e6, 60)
PROFILE = profile_of(LAW, Q)


def scene(rows, keys='psd_convention = "profile"'):
    table = ", ".join(f"[{q!r}, {c!r}]" for q, c in np.asarray(rows).tolist())
    return parse_scene(f"[surface]\npsd = [{table}]\n{keys}{BODY}")


def test_a_scene_takes_the_spectrum_of_profiles(tmp_path):
    found = scene(np.column_stack([Q, PROFILE]))
    inside = (Q < 7e5) & (np.abs(np.log(Q / 9.4e4)) > 0.15)  # away from the kink and from the end
    np.testing.assert_allclose(found.spectrum(Q[inside]), LAW(Q[inside]), rtol=0.03)
    assert found.spectrum.rms_slope == pytest.approx(LAW.rms_slope, rel=0.005)
    assert found.spectrum.rms_height == pytest.approx(LAW.rms_height, rel=0.01)
    assert (found.surface.psd_convention, found.surface.psd_source) == ("persson", "scan")
    assert len(found.surface.psd_error) == Q.size
    assert parse_scene(found.to_toml()) == found
    np.savetxt(tmp_path / "c1.csv", np.column_stack([Q, PROFILE]), delimiter=",")
    text = f'[surface]\npsd_file = "c1.csv"\npsd_convention = "profile"{BODY}'
    assert parse_scene(text, folder=tmp_path).spectrum.rms_slope == pytest.approx(
        found.spectrum.rms_slope
    )
    measured = scene(
        np.column_stack([Q, PROFILE]), 'psd_convention = "profile"\npsd_source = "scan"'
    )
    assert measured.surface.psd_error is None  # unknown


def test_a_table_without_an_isotropic_surface_is_refused():
    peak = PROFILE * (1 + 5 * np.exp(-(((Q - 3e5) / 2e4) ** 2)))
    with pytest.raises(
        SceneError, match=r"surface.psd gives a negative C\(q\) at q = .*; average it"
    ):
        scene(np.column_stack([Q, peak]))
    with pytest.raises(SceneError, match=r"surface.psd\[1\] has q = 10.0 rad/m after"):
        scene([[20.0, 1e-10], [10.0, 1e-11]])
    with pytest.raises(
        SceneError, match="surface.psd_convention = .profile. is converted by roughsim.load"
    ):
        type(scene(np.column_stack([Q, PROFILE])).surface)(
            psd=((1e4, 1e-20), (1e5, 1e-22)), psd_convention="profile"
        )
