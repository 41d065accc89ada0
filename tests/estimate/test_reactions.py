"""Means over the bins of contacts: closed cases, the derivative of each, and the errors that follow from T_flash."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy
from ladder_cases import NAME, ladder, lowest, part_of

from roughsim.estimate.contacts import Contacts, factor_of
from roughsim.estimate.errors import spread
from roughsim.estimate.levels import PIXEL_FALL
from roughsim.estimate.mean import Mean
from roughsim.estimate.reactions import (
    BOLTZMANN,
    Activation,
    ContactMean,
    heat_above,
    law_of_flash,
    mean_over_contact,
)
from roughsim.observables.distribution import BIN_AREAS, Bins, binned
from roughsim.observables.record import bins_of

EV = 1.602176634e-19
SCENE = SimpleNamespace()  # the predictions of `foretold` read no scene


def over(column, pairs, of_level, end):
    law, flash = law_of_flash(SCENE, column, pairs, end), of_level.flash
    contacts = Contacts(pairs, flash, flash, np.zeros(1), (1.0,), law, end, PIXEL_FALL[column])
    return mean_over_contact(contacts, of_level)


def of_pixels(temperature, pressure):
    """Bins of one contact at one speed, (1, 1, bins)."""
    order = np.argsort(temperature)
    return Bins(*(row[None, None] for row in binned(temperature[order], pressure[order])))


def mean_rate(bins, factor, activation):
    scale = activation.log_scale(bins, factor)
    scaled = activation._replace(scale=scale)
    return (scaled.rates(bins, factor) @ BIN_AREAS) * np.exp(scale)


def hertz(t_max=500.0, pixels=200_000):
    """A resting Hertz contact: by area, u = 1 − r²/R² is uniform, T = T₁(1 + u)/2 and σ = σ₁√u."""
    u = (np.arange(pixels) + 0.5) / pixels
    return of_pixels(0.5 * t_max * (1.0 + u), 1e9 * np.sqrt(u))


@pytest.mark.parametrize(("energy", "base"), [(0.6, 700.0), (1.0, 300.0), (1.5, 300.0)])
def test_the_rate_over_a_resting_hertz_contact_is_closed(energy, base):
    # T is uniform from ½T₁ to T₁, and ∫exp(−a/T)dT = T exp(−a/T) − a E₁(a/T)
    a = energy * EV / BOLTZMANN
    low, high = (
        t * np.exp(-a / t) - a * scipy.special.exp1(a / t) for t in (base + 250.0, base + 500.0)
    )
    found = mean_rate(hertz(), np.ones(1), Activation(energy * EV, 0.0, np.array([base])))
    assert found == pytest.approx((high - low) / 250.0, rel=5e-3)  # width of the bins


def test_without_a_barrier_all_attempts_succeed():
    found = mean_rate(hertz(), np.ones(1), Activation(0.0, 0.0, np.array([300.0])))
    assert found == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("volume", [-2e-29, 1e-29, 3e-29])
def test_pressure_lowers_the_barrier_pixel_by_pixel(volume):
    rng = np.random.default_rng(5)
    z, other = rng.standard_normal((2, 100_000))
    temperature, pressure = 200.0 + 50.0 * z, 1e9 + 1e8 * (0.5 * z + other)
    activation = Activation(0.8 * EV, volume, np.array([700.0]))
    direct = np.exp(
        (pressure * volume - 0.8 * EV) / (BOLTZMANN * (700.0 + 1.5 * temperature))
    ).mean()
    assert mean_rate(
        of_pixels(temperature, pressure), np.full(1, 1.5), activation
    ) == pytest.approx(direct, rel=5e-3)


@pytest.mark.parametrize("volume", [0.0, 2e-29])
def test_a_contact_of_one_temperature_has_it_as_its_activation_temperature(volume):
    bins = hertz()
    activation = Activation(EV, volume, np.array([650.0]))
    cold = np.zeros(1)
    scale = activation.log_scale(bins, cold)
    activation = activation._replace(scale=scale)
    each = activation.rates(bins, cold) @ BIN_AREAS
    temperature, slope, rows = activation.uniform_temperature(bins, each)
    assert temperature == pytest.approx(650.0, rel=1e-12)
    np.testing.assert_allclose(rows, np.broadcast_to(temperature, each.shape), rtol=1e-10)
    # the slope by a difference
    above = activation.uniform_temperature(bins, 1.001 * each)[0]
    assert slope * each.mean(axis=0) == pytest.approx(
        (above - temperature) / np.log(1.001), rel=1e-2
    )
    if not volume:  # T = E/(k ln 1/mean)
        log_mean = np.log(each.mean()) + scale
        assert temperature == pytest.approx(-EV / (BOLTZMANN * log_mean), rel=1e-12)


def pair_under_one_load(cold=(200.0, 300.0), hottest=(200.0, 300.0)):
    """Contacts at 1 and 3 GPa: under the same load the second has a third of the area of the first."""
    shape = np.ones((2, 1, BIN_AREAS.size))
    pair = lowest(np.full((2, 1), 250.0))
    kelvin, pressure = (np.array(two)[:, None, None] * shape for two in (cold, (1e9, 3e9)))
    kelvin[..., -1] = np.array(hottest)[:, None]
    object.__setattr__(pair, "bins", Bins(kelvin, pressure, 0.0 * shape, 0.0 * shape))
    return pair


def test_contacts_react_by_their_area():
    pair, flash = pair_under_one_load(), flash_values(250.0)
    activation = Activation(EV, 2e-29, np.array([500.0]))

    def mean(kelvin):
        return np.exp((np.array([1e9, 3e9]) * 2e-29 - EV) / (BOLTZMANN * kelvin)) @ [0.75, 0.25]

    of_level, scale = rate_of([pair], flash, activation)
    exact = mean(np.array([700.0, 800.0]))
    assert of_level.value(pair) * np.exp(scale) == pytest.approx(exact, rel=1e-9)
    warm = scipy.optimize.brentq(lambda kelvin: mean(kelvin) - exact, 500.0, 900.0)
    of_warm = of_temperature([pair], flash, activation)
    assert of_warm.value(pair) == pytest.approx(warm, rel=1e-9)
    rate = activation._replace(scale=scale).of_uniform_temperature(flash_values(warm), pair)
    assert rate.value * np.exp(scale) == pytest.approx(exact, rel=1e-9)


def test_the_hottest_pixels_count_by_the_area_of_their_contact():
    pair = pair_under_one_load(hottest=(400.0, 900.0))
    of_level = ContactMean(lambda bins, factor: bins.temperature, flash_values(250.0))
    last = BIN_AREAS[-1]
    hot = last * (0.75 * 400.0 + 0.25 * 900.0)
    whole = hot + (1.0 - last) * (0.75 * 200.0 + 0.25 * 300.0)
    assert of_level.tail(pair) == pytest.approx(hot / whole, rel=1e-9)


def test_contacts_under_one_load_set_free_as_much_heat():
    pair = pair_under_one_load()
    above = ContactMean(
        lambda bins, factor: heat_above(bins, factor, np.array([250.0])),
        flash_values(250.0),
        by_contact=True,
    )
    np.testing.assert_allclose(above.influence(pair), [[0.0], [1.0]], atol=1e-12)
    assert above.value(pair) == pytest.approx(0.5)


@pytest.mark.parametrize("volume", [0.0, 2e-29])
def test_the_rate_follows_from_the_activation_temperature_with_its_errors(volume):
    activation = Activation(EV, volume, np.array([650.0]))
    sample = SimpleNamespace(bins=hertz())
    pressures = 1e9 * np.sqrt((np.arange(10_000) + 0.5) / 10_000)

    def exact(temperature):
        return np.exp((pressures * volume - EV) / (BOLTZMANN * temperature)).mean()

    scale = np.array([-10.0])
    warm = flash_values(800.0, error=3.0, rows=np.array([[1.0], [-1.0]]))
    rate = activation._replace(scale=scale).of_uniform_temperature(warm, sample)
    assert rate.value * np.exp(scale) == pytest.approx(exact(800.0), rel=1e-3)
    expected = np.log(exact(800.1) / exact(799.9)) / 0.2
    slope = expected * rate.value
    assert rate.errors["bandwidth"] == pytest.approx(3.0 * slope, rel=1e-3)
    np.testing.assert_allclose(rate.influence[0], slope * np.array([[1.0], [-1.0]]), rtol=1e-3)


def test_without_a_barrier_there_is_no_activation_temperature():
    activation = Activation(0.0, 0.0, np.array([300.0]))
    with np.errstate(all="ignore"):
        assert np.isnan(activation.uniform_temperature(hertz(), np.ones((1, 1)))[0])


def test_heat_above_a_temperature_of_a_hertz_contact_is_closed():
    # the heat within r is 1 − u^(3/2), and T > t there if u > 2t/T₁ − 1
    bins = hertz(400.0)
    for t in (210.0, 300.0, 390.0):
        found = heat_above(bins, np.full(1, 2.0), np.array([2.0 * t]))
        assert found[0, 0] == pytest.approx(
            1.0 - (t / 200.0 - 1.0) ** 1.5, abs=4e-3
        )  # width of the cold bins
    assert heat_above(bins, np.ones(1), np.array([150.0])) == 1.0
    assert heat_above(bins, np.ones(1), np.array([450.0])) == 0.0


def flash_values(mean, error=0.0, rows=None):
    mean = np.atleast_1d(float(mean))
    errors = {"bandwidth": np.full(1, error), "pixel": np.zeros(1), "last step": np.zeros(1)}
    scatter = {} if rows is None else {0: rows}
    return Mean(mean, mean, scatter, errors)


def with_bins(pairs, deviation=0.3, seed=1):
    """Levels whose members have normal distributions about their own T_flash, with tails that differ a little."""
    rng = np.random.default_rng(seed)
    quantiles = scipy.stats.norm.ppf((np.arange(4000) + 0.5) / 4000)
    one = binned(quantiles, np.full(4000, 1e9)).temperature

    def filled(sample):
        flash = sample.numbers[NAME][:, :, None]
        width = deviation * (1.0 + 0.05 * rng.standard_normal((len(flash), 1, 1)))
        shape = np.ones((*flash.shape[:2], BIN_AREAS.size))
        pressure = 1e9 * (1.0 + 0.2 * rng.standard_normal((len(flash), 1, 1))) * shape
        bins = Bins(flash * (1.0 + width * one), pressure, 0.0 * shape, 0.0 * shape)
        object.__setattr__(sample, "bins", bins)
        return sample

    return [replace(filled(pair), below=pair.below and filled(pair.below)) for pair in pairs]


def rate_of(pairs, flash, activation):
    samples = [sample for pair in pairs for sample in (pair, pair.below) if sample is not None]
    scale = np.max([activation.log_scale(bins_of(s), factor_of(s, flash)) for s in samples], axis=0)
    return ContactMean(activation._replace(scale=scale).rates, flash), scale


def of_temperature(pairs, flash, activation):
    of_level, scale = rate_of(pairs, flash, activation)
    of_mean = activation._replace(scale=scale).uniform_temperature
    return ContactMean(of_level.of_bins, flash, of_mean)


def test_each_level_is_brought_to_the_continued_flash_temperature(foretold):
    foretold.theory = lambda column, q, observable: np.array([[300.0], [250.0], [220.0]])
    activation = Activation(EV, 0.0, np.array([400.0]))
    levels = with_bins(ladder([300.0, 250.0], [1.0, 2.0]), seed=2)
    for pair in levels:  # the same shape on both levels
        for sample in (pair, pair.below):
            if sample is not None:
                flash = sample.numbers[NAME][:, :, None]
                object.__setattr__(
                    sample,
                    "bins",
                    sample.bins._replace(temperature=flash * np.linspace(0.2, 2.5, 48)),
                )
    flash = flash_values(220.0, error=11.0)
    of_level, scale = rate_of(levels, flash, activation)
    found = over("capped", levels, of_level, 1e9)
    temperature = 400.0 + 220.0 * np.linspace(0.2, 2.5, 48)
    exact = BIN_AREAS @ np.exp(-EV / (BOLTZMANN * temperature) - scale)
    assert found.value == pytest.approx(exact, rel=1e-9)
    slope = BIN_AREAS @ (
        np.exp(-EV / (BOLTZMANN * temperature) - scale)
        * (EV / (BOLTZMANN * temperature**2))
        * (temperature - 400.0)
    )
    assert found.errors["bandwidth"] == pytest.approx(slope * 11.0 / 220.0, rel=1e-4)
    areas = 1.0 / levels[0].bins.pressure[:, 0, 0]  # of contacts that bear the same load
    np.testing.assert_allclose(of_level.members(levels[0]), areas.sum() ** 2 / (areas @ areas))


@pytest.mark.parametrize("warm", [False, True])
def test_influence_values_of_a_rate_are_those_of_a_jackknife(warm):
    n = 30
    rng = np.random.default_rng(8)
    pairs = with_bins([lowest(250.0 * (1.0 + 0.1 * rng.standard_normal((n, 1))))])
    activation = Activation(EV, 1e-29, np.array([500.0]))
    flash = flash_values(230.0)
    of_level = (
        of_temperature(pairs, flash, activation) if warm else rate_of(pairs, flash, activation)[0]
    )
    sample = pairs[0]

    def value(rows):
        part = part_of(sample, rows)
        return of_level.value(part)

    without = np.array([value(np.delete(np.arange(n), i)) for i in range(n)])
    rows = of_level.influence(sample)
    assert rows.mean(axis=0) == pytest.approx(value(np.arange(n)), rel=1e-6)
    error = np.sqrt((n - 1) * np.mean((without - without.mean(axis=0)) ** 2, axis=0))
    np.testing.assert_allclose(spread(rows)[0], error, rtol=0.1)
    assert np.corrcoef(rows[:, 0], -without[:, 0])[0, 1] > 0.98


def test_errors_of_an_activation_temperature_follow_from_its_own_slope_over_the_flash_temperature():
    pairs = with_bins([lowest(np.full((9, 1), 250.0))])
    activation = Activation(EV, 1e-29, np.array([500.0]))
    rows = np.array([[2.0], [-1.0], [-1.0]])  # scatter of T_flash on other surfaces

    def at(flash, rows=None):
        influence = {} if rows is None else {7: rows}
        values = replace(flash_values(flash, error=9.0), influence=influence)
        return over("capped", pairs, of_temperature(pairs, values, activation), 1.0)

    found = at(230.0, rows)
    slope = (at(230.23).value - at(229.77).value) / 0.46  # K over K
    assert found.errors["bandwidth"] == pytest.approx(9.0 * slope, rel=1e-3)
    np.testing.assert_allclose(found.influence[7], slope * rows, rtol=1e-3)
    # the part of the hottest pixel, in K: what is left of T_act without it
    sample = pairs[0]
    of_level = of_temperature(pairs, flash_values(230.0), activation)
    mean, tail = of_level.mean(sample).mean(axis=0), of_level.tail(sample)
    less = of_level.of_mean(sample.bins, (mean * (1.0 - 0.01 * tail))[None])[0]
    exact = of_level.of_mean(sample.bins, mean[None])[0] - less
    assert 0.01 * found.errors["tail"] == pytest.approx(exact, rel=1e-2)


@pytest.mark.parametrize(
    ("column", "fall"), [("capped", 0.75), ("smoothed", 0.3), ("elastic", 0.3)]
)
def test_a_finer_pixel_changes_a_rate_as_its_partner_shows(foretold, column, fall):
    foretold.law = np.array([[1.0], [1.0], [1.0]])
    low, finer = with_bins(
        ladder([250.0, 250.0], [1.0, 1.0]), seed=6
    )  # the second has the same cut-off
    activation = Activation(0.4 * EV, 0.0, np.array([600.0]))
    of_level, _ = rate_of([low, finer], flash_values(250.0), activation)
    change = of_level.influence(finer).mean() / of_level.influence(finer.below).mean() - 1.0
    assert abs(change) > 1e-3
    for end, carried in (1.0, 1.0), (16.0, 16.0**-fall):
        found = over(column, [low, finer], of_level, end)
        mean = of_level.mean(low).mean()
        assert found.value == pytest.approx(mean * (1.0 + carried * change), rel=1e-6)
        moved = 0.0 if end == 1.0 else carried  # to a higher cut-off, all of it is in doubt
        assert found.errors["pixel"] == pytest.approx(
            np.hypot(1.5 * carried, moved) * abs(change) * mean, rel=0.05
        )


def test_what_changes_with_the_cut_off_follows_the_steps_of_the_law_and_is_in_doubt_as_a_whole(
    foretold,
):
    foretold.law = np.array([[10.0], [8.0], [7.0]])
    pairs = with_bins(ladder([300.0, 240.0], [1.0, 2.0]), deviation=0.3, seed=4)
    activation = Activation(EV, 0.0, np.array([600.0]))
    flash = flash_values(210.0)
    of_level, _ = rate_of(pairs, flash, activation)
    found = over("capped", pairs, of_level, 1e9)
    at_cut_off = over("capped", pairs, of_level, 2.0)
    low = of_level.mean(pairs[0]).mean()
    ratio = of_level.mean(pairs[1]).mean() / of_level.mean(pairs[1].below).mean()
    assert at_cut_off.value == pytest.approx(low * ratio, rel=1e-6)
    assert at_cut_off.errors["bandwidth"] == 0.0
    rest = (low * ratio - low) * (7.0 - 8.0) / (8.0 - 10.0)
    assert found.value == pytest.approx(low * ratio + rest, rel=1e-6)
    assert found.errors["bandwidth"] == pytest.approx(abs(rest), rel=1e-6)
    foretold.law = None
    assert np.isnan(over("capped", pairs, of_level, 1e9).errors["bandwidth"])


def test_a_rate_from_a_few_hot_pixels_of_one_member_has_an_unknown_error(foretold):
    pairs = with_bins([lowest(np.full((8, 1), 250.0))])
    hot = pairs[0].bins.temperature
    hot[0, 0, -6:] = 2500.0  # in one member, 2e-4 of the area
    activation = Activation(1.5 * EV, 0.0, np.array([300.0]))
    flash = flash_values(250.0)
    of_level, _ = rate_of(pairs, flash, activation)
    found = over("capped", pairs, of_level, 1.0)
    assert of_level.members(pairs[0]) < 1.1
    assert np.isnan(found.errors["tail"])
    # where the whole contact reacts, the hottest pixels count by their area
    mild, _ = rate_of(pairs, flash, Activation(0.0, 0.0, np.array([300.0])))
    even = over("capped", pairs, mild, 1.0)
    assert mild.members(pairs[0]) == pytest.approx(8.0, rel=0.05)  # their areas scatter
    assert even.errors["tail"] < 1e-3
