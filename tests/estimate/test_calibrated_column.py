"""The column calibrated: contacts that the law draws, continued to all of C(q), and the parts of their error."""

from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim.estimate import contacts, fields
from roughsim.estimate.reactions import (
    BOLTZMANN,
    ELECTRONVOLT,
    ContactMean,
    heat_above,
    mean_over_contact,
)
from roughsim.observables.distribution import (
    BIN_AREAS,
    LEVELS,
    Bins,
    area_quantiles,
    binned,
    weighted_quantiles,
)
from roughsim.observables.record import Sample
from roughsim.prediction.fields import FrozenFields

NAMES = {
    weight: [f"temperature_quantile_{weight}{name}" for name in LEVELS] for weight in ("", "area_")
}


def sample(q_max, contacts):
    """A sample of contacts at one speed, each with ascending temperatures and pressures of its points."""
    levels = np.array([*LEVELS.values()])
    rows, bins = [], []
    for temperature, pressure in contacts:
        by_heat = weighted_quantiles(temperature, pressure, levels)
        by_area = area_quantiles(temperature, levels)
        row = dict(zip(NAMES[""], by_heat, strict=True)) | dict(
            zip(NAMES["area_"], by_area, strict=True)
        )
        rows.append(row | {"flash_temperature": np.average(temperature, weights=pressure)})
        bins.append(binned(temperature, pressure))
    numbers = {name: np.array([[row[name]] for row in rows]) for name in rows[0]}
    together = Bins(*(np.array(part)[:, None] for part in zip(*bins, strict=True)))
    nothing = np.empty((len(rows), 0))
    return Sample(
        q_max, 64.0, np.arange(len(rows)), numbers, np.empty(0), nothing, 0.0, bins=together
    )


def spread(width, seed=1, count=4000):
    """Points about 100 K with this deviation, over 100 K."""
    rng = np.random.default_rng(seed)
    temperature = np.sort(100.0 * (1.0 + width * rng.uniform(-1.7, 1.7, count)))
    return temperature, np.full(count, 2.0)


def column(widths, flash, reported=100.0, uncertainty=0.0, band=0.0):
    samples = tuple(
        sample(q, [spread(width, seed) for seed in range(6)])
        for q, width in zip((1.0, 2.0), widths, strict=False)
    )
    drawn = FrozenFields(samples, np.array(flash)[:, None])
    given = fields.by_law(np.array([reported]), band)
    return fields.drawn_frozen(drawn, 64.0, given, uncertainty)


def test_temperatures_go_on_in_proportion_to_the_flash_temperature():
    # T_flash of the law from 100 to 80 K, and 70 K at the end: half a step more
    found = column((0.2, 0.4), (100.0, 80.0, 70.0), reported=70.0)
    plain = column((0.2, 0.4), (100.0, 80.0, 80.0))  # no step is known: as the finer fields
    coarse = column((0.2,), (100.0, 100.0))
    for name in (*NAMES[""], *NAMES["area_"]):
        below, high = (fields.quantile_of(one, name).value / 100.0 for one in (coarse, plain))
        kelvin = 80.0 * high + 0.5 * (80.0 * high - 100.0 * below)
        assert fields.quantile_of(found, name).value == pytest.approx(kelvin, rel=2e-3)
        rest = np.abs(fields.quantile_of(found, name).value - 70.0 * high)
        assert fields.quantile_of(found, name).errors["bandwidth"] == pytest.approx(rest, abs=1e-9)
    furthest, limit = (column((0.2, 0.4), (100.0, 80.0, end), reported=1.0) for end in (10.0, 40.0))
    back = column((0.2, 0.4), (100.0, 80.0, 90.0))
    name = NAMES[""][5]
    assert fields.quantile_of(furthest, name).value == pytest.approx(
        fields.quantile_of(limit, name).value, rel=1e-12
    )
    assert fields.quantile_of(back, name).value == pytest.approx(
        fields.quantile_of(plain, name).value, rel=1e-12
    )


def test_a_share_of_hot_heat_goes_on_as_the_temperatures():
    found = column((0.2, 0.4), (100.0, 80.0, 70.0))
    of_bins = lambda bins, factor: heat_above(bins, factor, np.array([120.0]))  # noqa: E731
    of_level = ContactMean(of_bins, found.flash, by_contact=True)
    values = mean_over_contact(found, of_level)
    plain = mean_over_contact(column((0.4,), (1.0, 1.0)), of_level)
    assert values.value > plain.value
    assert values.errors["bandwidth"] > 0.0
    assert set(values.errors) == {"bandwidth", "form", "law", "tail"}


def test_the_drawing_is_the_scatter_of_equal_fields():
    name = NAMES[""][5]
    found = fields.quantile_of(column((0.2,), (1.0, 1.0)), name)
    one = column((0.2,), (1.0, 1.0)).samples[0].numbers
    ratio = one[name] / one["flash_temperature"]
    assert found.influence[0].std(ddof=1) * 6 == pytest.approx(100.0 * ratio.std(ddof=1), rel=0.02)


def test_the_law_and_the_form_are_parts_of_the_error():
    name = NAMES[""][5]
    found = fields.quantile_of(column((0.2,), (1.0, 1.0), uncertainty=0.1, band=0.07), name)
    assert found.errors["law"] == pytest.approx(0.07 * found.value, rel=1e-12)
    x = found.value / 100.0 - 1.0
    # warmer by 1.4 · .1; the hotter side evener, the colder not; both with their mean restored
    assert found.errors["form"] > 0.14 * found.value
    assert found.errors["form"] == pytest.approx(
        np.hypot(0.14 * found.value, 0.1 * x**1.5 * 100.0), rel=0.1
    )
    assert fields.quantile_of(column((0.2,), (1.0, 1.0)), name).errors["form"] == 0.0


def test_the_doubt_of_fields_falls_with_the_speed():
    # from .24 of a slow source by .02 for each factor e, to .06
    found = contacts.form_uncertainty([0.0, 1e-3, 1.0, np.e, np.e**2, 1e6])
    np.testing.assert_allclose(found, [0.24, 0.24, 0.17, 0.15, 0.13, 0.06], rtol=1e-12)


@pytest.mark.parametrize("pressure", [[1.0] * 5, [3.0, 0.5, 1.0, 0.2, 2.0]])
def test_doubted_contacts_are_evener_on_one_side_or_hotter(pressure):
    temperature, pressure = np.array([0.36, 0.75, 1.0, 1.4, 1.49]), np.array(pressure)
    temperature = temperature / np.average(temperature, weights=pressure)  # T_flash is 1
    plain = sample(1.0, [(temperature, pressure)])
    numbers = plain.numbers | {"temperature_quantile_50": np.array([[1.2]])}
    hot, cold, warm = contacts._displaced(replace(plain, numbers=numbers), 0.2)
    over = plain.bins.temperature[0, 0]
    x = over - 1.0
    nearer = np.sign(x) * (np.abs(x) - 0.2 * np.abs(x) ** 1.5)
    for one, side in (hot, x > 0.0), (cold, x < 0.0):
        shape = 1.0 + np.where(side, nearer, x)
        scale = one.bins.temperature[0, 0] / shape
        assert scale == pytest.approx(scale[0], rel=1e-12)
        heat = BIN_AREAS * plain.bins.pressure[0, 0]
        assert one.bins.temperature[0, 0] @ heat == pytest.approx(over @ heat, rel=1e-12)
    found = hot.numbers["temperature_quantile_50"] / hot.bins.temperature[0, 0, 0] * over[0]
    assert found == pytest.approx(1.0 + 0.2 - 0.2 * 0.2**1.5, rel=1e-12)
    np.testing.assert_allclose(warm.bins.temperature[0, 0], 1.28 * over, rtol=1e-12)
    np.testing.assert_allclose(warm.numbers["temperature_quantile_50"], 1.28 * 1.2, rtol=1e-12)
    # further from T_flash than 4/9/doubt² all points come to the same place
    far = contacts._evened(np.array([41.0, 61.0]), np.array(0.5), 1.0)
    np.testing.assert_allclose(far, 1.0 + 16 / 9 - 0.5 * (16 / 9) ** 1.5, rtol=1e-12)


def test_fields_corrected_at_rest_lack_contact_without_heat():
    plain = column((0.2,), (1.0, 1.0), uncertainty=0.12)
    found = plain._replace(shifts=contacts.WALKED[1])
    name, other = NAMES[""][5], NAMES["area_"][5]
    x = fields.quantile_of(found, name).value / 100.0 - 1.0
    # the hotter side evener, with the mean restored
    assert 6.0 * x**1.5 < fields.quantile_of(found, name).errors["form"] < 12.0 * x**1.5
    by_area = [fields.quantile_of(one, other).errors["form"] for one in (found, plain)]
    assert by_area[0] > by_area[1]
    *_, warm = contacts._displaced(found.samples[-1], np.array(0.12), found.shifts)
    growth = warm.bins.temperature / found.samples[-1].bins.temperature
    np.testing.assert_allclose(growth, 1.0 + 0.12 * 0.5, rtol=1e-12)


STRETCH = np.array([1.5])
DOUBT = 0.15  # of slides by their form


def slid():
    """Slides whose contacts are alike, as drawn with T_flash 100 K, and what the form of the fields may be instead.

    That is their temperatures in the bins, and a function of a single temperature, all over T_flash.
    """
    contact = spread(0.3)
    one = sample(1.0, [contact] * 3)
    slides = {f"sliding_{name}": values for name, values in one.numbers.items()}
    one = replace(one, numbers=one.numbers | slides)
    flash = one.numbers["flash_temperature"][0, 0]
    over = one.bins.temperature[0, 0] / flash
    heat = BIN_AREAS * one.bins.pressure[0, 0]

    def nearer(x, side):
        return np.where(side * x > 0.0, np.sign(x) * (np.abs(x) - DOUBT * np.abs(x) ** 1.5), x)

    others = [lambda t: (1.0 + 1.4 * DOUBT) * t]
    for side in (1.0, -1.0):
        unit = (heat @ over) / (heat @ (1.0 + nearer(over - 1.0, side)))
        others.append(lambda t, side=side, unit=unit: unit * (1.0 + nearer(t - 1.0, side)))
    return one, over, others


def test_a_quantile_of_slides_errs_by_the_form_as_far_as_it_is_stretched():
    slides, _, others = slid()
    name = NAMES[""][5]
    found = fields.quantile_of(
        fields.drawn_slides(slides, fields.by_law(np.array([100.0]), 0.0, "slide"), STRETCH), name
    )
    over = slides.numbers[name][0, 0] / slides.numbers["flash_temperature"][0, 0]
    changes = [1.5 * 100.0 * (other(over) - over) for other in others]
    assert found.errors["form"] == pytest.approx(np.linalg.norm(changes), rel=1e-9)


def test_a_mean_over_slides_errs_by_the_form_as_far_as_it_is_stretched():
    slides, over, others = slid()
    column = fields.drawn_slides(slides, fields.by_law(np.array([100.0]), 0.0, "slide"), STRETCH)
    of_level = ContactMean(lambda bins, factor: bins.temperature * factor[:, None], column.flash)
    found = mean_over_contact(column, of_level)
    assert found.value == pytest.approx(100.0 * (BIN_AREAS @ (1.0 + 1.5 * (over - 1.0))))
    changes = [1.5 * 100.0 * (BIN_AREAS @ (other(over) - over)) for other in others]
    assert found.errors["form"] == pytest.approx(np.linalg.norm(changes), rel=1e-9)


@pytest.mark.usefixtures("few_fields")
def test_the_form_is_in_doubt_by_the_speed_over_the_length_of_the_heights():
    changes = {"sliding.speed": [1.0, 35.0], "observables.temperature_distribution": True}
    scene = rs.load_scene("steel-1.2GPa", changes)
    breaks = np.log(scene.spectrum.breaks)
    q = np.exp(np.linspace(breaks[0], breaks[-1], 200_001))
    height, slope = (np.trapezoid(q**k * scene.spectrum(q), np.log(q)) for k in (2, 4))
    diffusivity = 30.0 / (7900.0 * 500.0)
    numbers = np.array([1.0, 35.0]) * np.sqrt(height / slope) / diffusivity
    expected = 0.17 - 0.02 * np.log(numbers)
    np.testing.assert_allclose(fields._frozen(scene, walk=False).form, expected, rtol=1e-4)


@pytest.mark.parametrize("energy", [0.6, 1.0, 1.5])
def test_an_even_contact_reacts_at_its_own_temperature(energy):
    from roughsim.estimate.asked import of_reaction
    from roughsim.scene.reactions import ReactionSection

    even = sample(1.0, [(np.full(50, 100.0), np.full(50, 3.0))] * 5)
    drawn = fields.drawn_frozen(
        FrozenFields((even,), np.ones((2, 1))), 1.0, fields.by_law(np.array([100.0]), 0.0), 0.0
    )
    area = fields.by_law(np.array([0.25]), 0.13)
    even_contact = drawn._replace(speeds=(1.0,), area=area, background=np.array([300.0]))
    barrier = energy * ELECTRONVOLT
    section = ReactionSection(activation_energy=(barrier,), prefactor=1e13)
    rate, kelvin = of_reaction(even_contact, section, barrier)
    assert kelvin.mean == pytest.approx(400.0, rel=1e-9)
    expected = 0.25 * 1e13 * np.exp(-barrier / (BOLTZMANN * 400.0))
    assert rate.mean == pytest.approx(expected, rel=1e-9)
    assert rate.budget["law"] == pytest.approx(0.13 * expected, rel=1e-9)
    assert rate.standard_error == 0.0
