"""docs/validity.md prints results of measured contacts: those that follow from the stored contacts are recomputed."""

from pathlib import Path

import numpy as np
import pytest
from law_cases import CONTACTS

import roughsim as rs
from theory import flash, persson, plasticity

PAGE = " ".join((Path(__file__).parents[2] / "docs" / "validity.md").read_text().split())
PECLET = np.array([1e-3, 1.0, 1e3])
GRID = [c for c in CONTACTS["elastic"] if c["plateau"] == 2.0]
CAPPED = CONTACTS["yielding"]


def spectrum(contact, q_max):
    return rs.SelfAffineSpectrum.from_rms_slope(
        1.0,
        hurst=contact["hurst"],
        q_min=1.0 / contact["plateau"],
        q_roll_off=1.0,
        q_max=q_max,
        roll_off_exponent=contact["low_exponent"],
    )


def heated(load):
    return {"friction_coefficient": load, "conductivity": 1.0, "diffusivity": 1.0, "nominal_pressure": load}


@pytest.fixture(scope="module")
def elastic():
    """Measured over theory with γ = 0.45 by quantity, shape (contacts, Péclet numbers or 1)."""
    rows = []
    for contact in GRID:
        load, psd = contact["load"], spectrum(contact, contact["bandwidth"])
        solid = {"effective_modulus": 1.0, "nominal_pressure": load}
        row = {
            name: getattr(flash, name)(PECLET, psd, effective_modulus=1.0, **heated(load))
            for name in ("flash_temperature", "flash_width", "slope_length")
        }
        row["pressure_variance"] = persson.pressure_correlation(0.0, psd, **solid)
        row["contact_fraction"] = persson.contact_probability(contact["bandwidth"], psd, **solid)
        rows.append({name: contact[name]["value"] / value for name, value in row.items()})
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def high(ratio):
    """Theory/measured − 1 in %, least and most."""
    return 100 / ratio.max() - 100, 100 / ratio.min() - 100


def test_elastic_contact_in_short(elastic):
    loads = np.array([contact["load"] for contact in GRID])
    heavy, light = loads == 0.6, loads == 0.002
    slow, _, fast = elastic["flash_temperature"].T
    numbers = *high(slow[heavy]), *high(slow[light])
    assert "by {:.0f} to {:.0f} % near full contact and {:.0f} to {:.0f} % under".format(*numbers) in PAGE
    assert f"too cool by up to {-high(fast)[0]:.0f} %" in PAGE
    assert max(np.abs(high(fast[heavy]))) < 1.0  # "within 1 % near full contact"
    assert f"from {-high(fast[light])[0]:.0f} % too cool to {high(fast[light])[1]:.0f} % too hot under" in PAGE
    widths = [1 / elastic[name].min() for name in ("flash_width", "slope_length")]
    assert f"too large by a factor of up to {max(widths):.0f}" in PAGE
    area, variance = elastic["contact_fraction"], elastic["pressure_variance"]
    assert f"contact area is {100 * area.min() - 100:.0f} to {100 * area.max() - 100:.0f} % larger" in PAGE
    assert f"up to {100 * variance.max() - 100:.0f} % larger than the theory's" in PAGE
    worst = 100 * max(max(contact["flash_temperature"]["error"]) for contact in GRID)
    assert f"at most {worst:.1f} % for T_flash in elastic contact" in PAGE
    assert f"{len(GRID)} elastic contacts" in PAGE


def test_capped_contact_without_end_in_short():
    ratios = []
    for contact in CAPPED:
        if contact["depth"] is None:
            far = spectrum(contact, 512.0 * contact["yields"])
            psd = far.scaled(contact["level"] / float(far(np.array(1.0))))
            load = contact["share"] * contact["hardness"]
            solid = {"nominal_pressure": load, "penetration_hardness": contact["hardness"], "effective_modulus": 1.0}
            smoothed = plasticity.smoothed_spectrum(psd, **solid)
            theory = flash.flash_temperature(PECLET, smoothed, effective_modulus=1.0, **heated(load))
            ratios.append(contact["flash_temperature"]["value"] / theory)
    slow, _, fast = np.array(ratios).T
    limits = slow.min(), slow.max(), fast.min(), fast.max()
    assert "Capped contact over theory: slow {:.2f} to {:.2f}, fast {:.2f} to {:.2f}".format(*limits) in PAGE


@pytest.mark.parametrize("hurst", [0.3, 0.55, 0.8])
def test_where_c_ends(hurst):
    def place(contact):
        return tuple(contact[name] for name in ("share", "yields", "hurst", "plateau"))

    limits = {place(c): np.array(c["flash_temperature"]["value"]) for c in CAPPED if c["depth"] is None}
    grid = [c for c in CAPPED if c["hurst"] == hurst and c["plateau"] == 2.0]
    cells = []
    for depth in (4.0, 8.0, 16.0, 32.0, 64.0):
        excess = [c["flash_temperature"]["value"] / limits[place(c)] - 1 for c in grid if c["depth"] == depth]
        assert len(excess) == 10
        cells.append(f"{100 * np.min(excess):.0f} … {100 * np.max(excess):.0f}")
    assert f"| H = {hurst:g} | {' | '.join(cells)} |" in PAGE


def test_the_law_in_elastic_contact():
    names = {"T_flash": "flash_temperature", "T′_flash": "flash_gradient", "D_flash": "flash_width"}
    names |= {"d_flash": "slope_length", "g_σ(0)": "pressure_variance", "contact area": "contact_fraction"}
    departures = {name: [] for name in names.values()}
    other = []
    for contact in CONTACTS["elastic"]:
        law = persson.calibrated_spectrum(
            spectrum(contact, contact["bandwidth"]), effective_modulus=1.0, nominal_pressure=contact["load"]
        )
        found = {
            name: np.abs(getattr(flash, name)(PECLET, stress_spectrum=law, **heated(contact["load"])))
            for name in ("flash_temperature", "flash_gradient", "flash_width", "slope_length")
        }
        found["pressure_variance"] = persson.pressure_correlation(0.0, stress_spectrum=law)
        found["contact_fraction"] = law.contact_fraction
        logs = {name: 100 * np.log(value / contact[name]["value"]) for name, value in found.items()}
        if contact["plateau"] != 2.0:
            other.append(logs["flash_temperature"])
            continue
        for name, value in logs.items():
            departures[name].append(value)
    for words, name in names.items():
        values = np.array(departures[name])
        cells = values.mean(), np.sqrt((values**2).mean()), np.abs(values).max()
        assert "| {} | {:.1f} | {:.1f} | {:.1f} |".format(words, *cells).replace("-", "−") in PAGE
    assert f"At the {len(other)} elastic contacts with other plateaus" in PAGE
    assert f"T_flash by the law is at most {np.abs(other).max():.1f} % off" in PAGE
