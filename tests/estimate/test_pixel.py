"""The change by a vanishing pixel: at the cut-off of a partner, and carried to a higher one."""

import numpy as np
import pytest
from ladder_cases import (
    BOUND,
    END,
    GRADIENT,
    NAME,
    SLOW,
    SPEEDS,
    VARIANCE,
    at_speeds,
    ladder,
    with_partner,
)

from roughsim.estimate.levels import values_of
from roughsim.observables.catalogue import OBSERVABLES


@pytest.mark.parametrize(("column", "order"), [("elastic", 2.0), ("capped", 1.75)])
def test_a_partner_at_the_end_gives_the_vanishing_pixel(steel, column, order):
    pairs = with_partner(ladder(at_speeds(9.0, 7.5), (END / 2, END)), -0.06, END)
    values = values_of(steel, column, NAME, pairs)
    left = -0.06 / (2.0**order - 1.0)
    np.testing.assert_allclose(values.finest, 7.5 * 0.94, rtol=1e-12)
    np.testing.assert_allclose(values.value, 7.5 * (0.94 + left), rtol=1e-12)
    np.testing.assert_allclose(values.errors["pixel"], 7.5 * np.abs(left), rtol=1e-12)


@pytest.mark.parametrize(
    ("column", "order", "fall"), [("elastic", 2.0, 0.3), ("capped", 1.75, 0.75)]
)
def test_a_partner_lower_down_counts_by_what_is_left_of_it_at_the_end(steel, column, order, fall):
    pairs = with_partner(ladder(at_speeds(9.0, 7.5), (END / 4, END)), -0.06, END / 4)
    values = values_of(steel, column, NAME, pairs)
    change, left = -0.06 * 2.0**order / (2.0**order - 1.0), 0.06 / (2.0**order - 1.0)
    carried = 4.0**-fall
    np.testing.assert_allclose(values.value, 7.5 * (1.0 + carried * change), rtol=1e-12)
    np.testing.assert_allclose(
        values.errors["pixel"],
        7.5 * np.hypot(4.0 ** (-fall / 3) * change, carried * left),
        rtol=1e-12,
    )
    np.testing.assert_allclose(
        values.finest, 7.5, rtol=1e-12
    )  # the highest cut-off has no finer grid


@pytest.mark.parametrize("fast", [0.0, -0.01])
@pytest.mark.parametrize("name", [NAME, "temperature_quantile_50"])
def test_at_high_speed_a_partner_lower_down_leaves_what_the_pixel_changes_of_slow_contact_in_doubt(
    steel, name, fast
):
    pairs = with_partner(ladder(at_speeds(9.0, 7.5), (END / 4, END), name=name), fast, END / 4)
    pairs[-1].numbers[SLOW] = np.linspace(0.94, 1.0, SPEEDS) * pairs[-1].below.numbers[SLOW]
    for one in pairs:
        for sample in (one, one.below):
            if sample is not None:  # a quantile has these rows without bins of contacts
                sample.kept(name, lambda sample: sample.numbers[name])
    values = values_of(steel, "capped", name, pairs)
    change, left, slow = (x / (1.0 - 2.0**-1.75) for x in (fast, fast * 2.0**-1.75, 0.06))
    np.testing.assert_allclose(values.value, 7.5 * (1.0 + change * 4.0**-0.75), rtol=1e-12)
    np.testing.assert_allclose(
        values.errors["pixel"], 7.5 * np.hypot(slow * 4.0**-0.25, left * 4.0**-0.75), rtol=1e-12
    )


@pytest.mark.parametrize("name", ["contact_fraction", "pressure_variance", GRADIENT])
def test_areas_variance_and_what_has_no_limit_have_the_error_of_their_own_change(steel, name):
    stored = {"contact_fraction": "contact_fraction_corrected"}.get(name, name)
    bound = VARIANCE if name == "pressure_variance" else BOUND
    mean = 2.0 * bound if name == "contact_fraction" else 0.5 * bound
    pairs = with_partner(ladder(at_speeds(mean, mean), (END / 4, END), name=stored), -0.06, END / 4)
    pairs[-1].numbers[SLOW] = 0.5 * pairs[-1].below.numbers[SLOW]
    values = values_of(steel, "capped", name, pairs)
    order = OBSERVABLES[name].pixel_orders[1]
    change, left = (4.0**-0.75 * x / (1.0 - 2.0**-order) for x in (0.06, 0.06 * 2.0**-order))
    parts = change, left, change * (name == GRADIENT)  # nothing is corrected: in doubt as well
    np.testing.assert_allclose(values.errors["pixel"], mean * np.linalg.norm(parts), rtol=1e-12)
