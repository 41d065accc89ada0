"""The fresh contacts that yield: the committed list is what the seed draws, and they are what they are said to be."""

from dataclasses import asdict
from math import inf, nan, pi, sqrt

import law_cases  # noqa: F401  (finds the folder of the script)
import numpy as np
import pytest
import yielding_points
from contacts import ladder
from scipy.special import j0
from some_rows import some

from roughsim.surface.modes import mode_variance
from theory import flash, persson, plasticity
from theory.yielding import YieldingSpectrum

MEASURED = yielding_points.measured()
QUANTITIES = (
    "flash_temperature",
    "contact_fraction",
    "yielded_fraction",
    "pressure_variance",
    "correlation",
)


@pytest.mark.slow
def test_the_committed_list_is_what_the_seed_draws(tmp_path):
    yielding_points.write(yielding_points.drawn(), tmp_path / "again.json")
    assert (tmp_path / "again.json").read_text() == yielding_points.LIST.read_text()
    for read, drawn in zip(yielding_points.points(), yielding_points.drawn(), strict=True):
        np.testing.assert_equal(asdict(read), asdict(drawn))


def test_the_kinds_cover_what_they_are_for():
    contacts = yielding_points.points()
    kinds = {kind: [c for c in contacts if c.kind == kind] for kind in "ABC"}
    assert [len(some) for some in kinds.values()] == [25, 24, 42]
    assert all(c.q_max == inf and 0.25 <= c.yields <= 8 for c in kinds["A"])
    assert all(1 <= c.q_max / c.yields <= 10 for c in kinds["B"])
    assert all(1 <= c.q_max <= 32 and 0.1 <= c.yielded < 1 for c in kinds["C"])
    assert all(
        0.3 <= c.hurst <= 1 and 0.005 <= c.share <= 0.6 and 1 <= c.plateau <= 16 for c in contacts
    )


@pytest.mark.parametrize(
    "contact", some(yielding_points.points(), 4), ids=lambda contact: contact.name
)
def test_the_hardness_gives_the_yielded_share_of_the_theory(contact):
    # by the theory's own quadrature of G(q); 7 digits of the hardness are kept
    end = contact.q_max if contact.kind == "C" else contact.yields
    variance = persson.half_variance(end, contact.spectrum(2 * end), effective_modulus=1.0)
    _, elastic, plastic = plasticity.area_fractions(float(variance), contact.load, contact.hardness)
    assert plastic / (elastic + plastic) == pytest.approx(contact.yielded, rel=2e-6)


@pytest.mark.parametrize(
    "contact", some(yielding_points.points()), ids=lambda contact: contact.name
)
def test_the_law_takes_every_contact_that_it_was_compared_with(contact):
    solid = {
        "effective_modulus": 1.0,
        "nominal_pressure": contact.load,
        "penetration_hardness": contact.hardness,
    }
    far = 1e5 if contact.kind == "A" else contact.q_max
    if contact.name == "C28":  # has yielded at 9 q_r, beyond the range of q_y
        with pytest.raises(ValueError, match=r"q_y/q_roll_off = 9\.01"):
            plasticity.stress_spectrum(contact.spectrum(far), **solid)
        return
    assert isinstance(plasticity.stress_spectrum(contact.spectrum(far), **solid), YieldingSpectrum)


def test_full_contact_is_exact():
    # p = σ₀ + F⁻¹[E* q h_q/2]: with fixed amplitudes every member has |σ_q|² = (q/2)² |h_q|², mode by mode
    contact = yielding_points.Contact("C99", 0.7, 0.5, 2.0, 3.0, nan, nan, 400.0)
    large, rungs = ladder.ladder(contact, 1e4, 256)
    for rung in [large, rungs[1]]:
        values = dict(zip(ladder.COLUMNS, ladder.members_of(contact, rung, [1]).T, strict=False))
        q = rung.grid.wavenumbers
        stress = (
            mode_variance(contact.spectrum(), rung.grid) * (q / 2) ** 2 * rung.grid.multiplicity
        )
        waves = q > 0
        even, _ = flash.angular_integrals(1.0 / q[waves])
        assert values["pressure_variance"] == pytest.approx(stress.sum(), rel=1e-3)
        # T at Pe 1, by bins of |q| an eighth of the mode spacing wide
        assert values["flash_temperature-1"] == pytest.approx(
            2 / pi * (stress[waves] / q[waves]) @ even, rel=1e-3
        )
        assert values["contact_fraction"] == pytest.approx(1.0)
        assert values["yielded_fraction"] == pytest.approx(0.0)
        correlation = ladder.members_of(contact, rung, [1])[
            0, len(ladder.COLUMNS) + 20
        ]  # r = 0.48/q_r
        assert correlation == pytest.approx((stress * j0(q * ladder.DISTANCES[20])).sum(), rel=2e-3)
    levels = [ladder.members_of(contact, rung, [1]) for rung in rungs[:2]]
    spectrum = ladder.finest_spectrum(ladder.Solved(rungs[:2], levels, levels[0]))
    q, density = np.array(spectrum["q"]), np.array(spectrum["value"])
    inner = (q > 1.2) & (
        q < 2.4
    )  # away from the kink and the end of C(q); bands are a third of an octave wide
    assert inner.sum() >= 3
    np.testing.assert_allclose(
        density[inner], (q[inner] / 2) ** 2 * contact.spectrum()(q[inner]), rtol=0.03
    )


def test_a_ladder_ends_at_its_limit_and_takes_over_what_a_large_cell_changes():
    # 1 + 2^(−k) on rung k, all of it a tenth higher in the large cell
    rng = np.random.default_rng(3)
    common = rng.normal(0.0, 0.01, (256, 1))
    levels = [(1 + 0.5**k) * (1 + common[: 256 >> k]) for k in range(5)]
    large = 2.2 * (1 + rng.normal(0.0, 0.01, (64, 1)))
    rungs = [ladder.Rung(3.0, 2**k, 8.0, level.size) for k, level in enumerate(levels)]
    result = ladder.Solved(rungs, levels, large).value(0)
    assert result["value"] == pytest.approx(1.1, rel=result["error"])
    assert result["standard_error"] == pytest.approx(
        0.01 / sqrt(64), rel=0.3
    )  # the large cell is all that scatters
    assert result["error"] < 0.05
    assert result["bias"] == pytest.approx(0.5**4, rel=0.01)
    assert result["size"] == pytest.approx(ladder.SIZE_DOUBT * np.log(1.1), rel=0.1)


def test_what_is_measured_covers_the_kinds_and_is_small():
    contacts = {contact.name: contact for contact in yielding_points.points()}
    assert set(MEASURED) <= set(contacts)
    assert all(
        sum(name[0] == kind for name in MEASURED) >= least for kind, least in (("B", 6), ("C", 10))
    )
    assert len(MEASURED) >= 24
    for record in MEASURED.values():
        numbers = [
            np.asarray(record[name][key]) for name in QUANTITIES for key in ("value", "error")
        ]
        assert all(np.isfinite(some).all() and (some > 0).all() for some in numbers)
        error = record["flash_temperature"]["error"]
        assert max(error[0], error[3]) < (0.035 if record["name"] in ("A23", "C24") else 0.02)
        assert (
            error[6] < 0.07
        )  # H = 0.31 without end falls slowly with the cut-off under fast sliding
        assert len(record["correlation"]["r"]) >= 10
    assert sum(path.stat().st_size for path in yielding_points.MEASURED.iterdir()) < 400_000


@pytest.mark.parametrize("name", [name for name in MEASURED if name[0] == "A"])
def test_what_has_yielded_altogether_obeys_the_balance_of_forces(name):
    # A = A_pl = σ₀/σ_P and g_σ(0) = σ₀ σ_P − σ₀²; the ladder does not know it. Within four standard errors
    contact = next(contact for contact in yielding_points.points() if contact.name == name)
    known = {
        "contact_fraction": contact.share,
        "yielded_fraction": contact.share,
        "pressure_variance": contact.share * (1 - contact.share) * contact.hardness**2,
    }
    for quantity, value in known.items():
        assert MEASURED[name][quantity]["value"] == pytest.approx(
            value, rel=2 * MEASURED[name][quantity]["error"]
        )


def test_in_contact_that_yields_in_part_the_law_has_the_variance_that_was_measured():
    # where all has yielded it is force balance alone; here 0.7 or 0.9 for ANSWER is 2.2 % too low, 1.5 % too high
    off = []
    for contact in yielding_points.points():
        if contact.name in MEASURED and contact.kind == "C":
            law = YieldingSpectrum(contact.spectrum(), 1.0, contact.load, contact.hardness)
            found = float(persson.pressure_correlation(0.0, stress_spectrum=law))
            off.append(np.log(found / MEASURED[contact.name]["pressure_variance"]["value"]))
    assert np.mean(off) == pytest.approx(0.0, abs=0.01)
    assert np.abs(off).max() < 0.07


@pytest.mark.parametrize(
    "name", some(["B02", "B08", "B10", "B13", "B21", "C06", "C20", "C25", "C36"], 2)
)
def test_where_roughness_ends_soon_the_law_has_the_correlation_that_was_measured(name):
    # EDGE of 0.3 for 0.4 misses five of them
    contact = next(contact for contact in yielding_points.points() if contact.name == name)
    whole = MEASURED[name]["pressure_variance"]["value"]
    r, value, error = (
        np.array(MEASURED[name]["correlation"][key]) for key in ("r", "value", "error")
    )
    known = (value > 0.1 * whole) & (error < 0.03)
    law = YieldingSpectrum(contact.spectrum(), 1.0, contact.load, contact.hardness)
    found = persson.pressure_correlation(r[known], stress_spectrum=law)
    assert np.abs(found - value[known]).max() < 0.04 * whole
