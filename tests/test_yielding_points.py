"""The fresh contacts that yield: the committed list is what the seed draws, and they are what they are said to be."""

from dataclasses import asdict
from math import inf

import numpy as np
import pytest
import validity_cases  # noqa: F401  (finds the folder of the script)
import yielding_points

from theory import persson, plasticity


def test_the_committed_list_is_what_the_seed_draws(tmp_path):
    yielding_points.write(yielding_points.drawn(), tmp_path / "again.json")
    assert (tmp_path / "again.json").read_text() == yielding_points.LIST.read_text()
    for read, drawn in zip(yielding_points.points(), yielding_points.drawn(), strict=True):
        np.testing.assert_equal(asdict(read), asdict(drawn))


def test_the_kinds_cover_what_they_are_for():
    contacts = yielding_points.points()
    kinds = {kind: [c for c in contacts if c.kind == kind] for kind in "ABC"}
    assert [len(some) for some in kinds.values()] == [14, 6, 12]
    assert all(c.q_max == inf and 0.25 <= c.yields <= 8 for c in kinds["A"])
    assert all(1 <= c.q_max / c.yields <= 10 for c in kinds["B"])
    assert all(1 <= c.q_max <= 32 and 0.1 <= c.yielded < 1 for c in kinds["C"])
    assert all(0.3 <= c.hurst <= 1 and 0.005 <= c.share <= 0.6 and 1 <= c.plateau <= 16 for c in contacts)


@pytest.mark.parametrize("contact", yielding_points.points(), ids=lambda contact: contact.name)
def test_the_hardness_gives_the_yielded_share_of_the_theory(contact):
    # by the theory's own quadrature of G(q); 7 digits of the hardness are kept
    end = contact.q_max if contact.kind == "C" else contact.yields
    variance = persson.half_variance(end, contact.spectrum(2 * end), effective_modulus=1.0)
    _, elastic, plastic = plasticity.area_fractions(float(variance), contact.load, contact.hardness)
    assert plastic / (elastic + plastic) == pytest.approx(contact.yielded, rel=2e-6)
