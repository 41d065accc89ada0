"""The distribution of the temperature over a contact: quantiles by heat and area, and bins, against exact cases."""

import numpy as np
import pytest
import scipy

import roughsim as rs
from roughsim.observables import catalogue
from roughsim.observables.distribution import (
    BIN_AREAS,
    LEVELS,
    Bins,
    binned,
    pooled_quantiles,
    shares_of,
    two_pressures,
    weighted_quantiles,
)
from roughsim.observables.record import Sample
from roughsim.observables.temperatures import SlideFromRest, temperature_distribution

P = np.array([*LEVELS.values()])


def hertz(points, extent):
    """T/T₁ = 1 − r²/2R² of a resting Hertz contact, and its pressure √(1 − r²/R²), on a square of ±extent R."""
    x = extent * (2.0 * (np.arange(points) + 0.5) / points - 1.0)
    square = x[:, None] ** 2 + x**2
    return 1.0 - 0.5 * square, np.sqrt(np.maximum(1.0 - square, 0.0))


def sorted_contact(temperature, pressure):
    contact = pressure > 0.0
    order = np.argsort(temperature[contact])
    return temperature[contact][order], pressure[contact][order]


def of_hertz(weight):
    """Quantiles of T/T₁: by area it is uniform from ½ to 1; by heat the share 1 − (1 − r²)^(3/2) lies within r."""
    return 0.5 * (1.0 + (P if weight == "area" else P ** (2 / 3)))


@pytest.mark.parametrize("weight", ["heat", "area"])
def test_quantiles_of_a_resting_hertz_contact_are_closed(weight):
    values, pressure = sorted_contact(*hertz(800, 1.0))
    found = weighted_quantiles(values, pressure if weight == "heat" else np.ones_like(values), P)
    np.testing.assert_allclose(found, of_hertz(weight), atol=2e-4)  # a ring of pixels more or less


@pytest.mark.parametrize("points", [40, 400])
def test_bins_of_a_hertz_contact_are_uniform_in_temperature(points):
    bins = binned(*sorted_contact(*hertz(points, 1.0)))
    middle = (
        np.cumsum(BIN_AREAS) - 0.5 * BIN_AREAS
    )  # of a uniform distribution the mean of a bin is at its middle
    np.testing.assert_allclose(bins.temperature, 0.5 * (1.0 + middle), atol=1.5 / points)
    # pressure √(2T − 1): σ̄ of a bin from a to b of T/T₁ is ∫√(2T − 1)dT/(b − a)
    edges = np.concatenate([[0.0], np.cumsum(BIN_AREAS)])
    exact = np.diff(edges**1.5) / 1.5 / BIN_AREAS
    np.testing.assert_allclose(bins.pressure, exact, atol=1.0 / points)


def test_bins_keep_the_moments_of_all_pixels_however_few_they_are():
    rng = np.random.default_rng(11)
    for pixels in (1, 7, 400, 9000):
        temperature = np.sort(rng.normal(300.0, 80.0, pixels))
        pressure = rng.gamma(2.0, 1e8, pixels)
        bins = binned(temperature, pressure)
        assert BIN_AREAS @ bins.temperature == pytest.approx(temperature.mean(), rel=1e-12)
        for power in (1, 2, 3):
            of_bins = sum(share * value**power for value, share in two_pressures(bins))
            assert BIN_AREAS @ of_bins == pytest.approx((pressure**power).mean(), rel=1e-9)
        assert np.all(np.diff(bins.temperature) >= -1e-9)


def test_the_hottest_bins_lie_within_the_hottest_pixel_of_a_small_contact():
    rng = np.random.default_rng(11)
    temperature = np.sort(rng.random(100))
    hottest = np.cumsum(BIN_AREAS[::-1])[::-1] <= 0.01  # within the last of a hundred
    np.testing.assert_allclose(
        binned(temperature, np.ones(100)).temperature[hottest], temperature[-1], rtol=1e-9
    )
    assert hottest.sum() > 15


def test_uniform_pressure_has_no_deviation():
    rng = np.random.default_rng(11)
    bins = binned(np.sort(rng.random(5000)), np.full(5000, 1.2e9))
    np.testing.assert_allclose(bins.pressure, 1.2e9, rtol=1e-12)
    assert not bins.pressure_deviation.any()
    assert not bins.pressure_skewness.any()


def test_the_mean_of_an_exponential_over_normal_temperature_and_pressure_is_closed():
    rng = np.random.default_rng(11)
    # ⟨exp(aσ + bT)⟩ = exp(aσ̄ + (a²s² + 2abrst + b²t²)/2): full contact has σ and T jointly normal
    t, s, correlation, mean = 30.0, 0.1, 0.6, 1.0
    z, other = rng.standard_normal((2, 400_000))
    temperature = t * z
    pressure = mean + s * (correlation * z + np.sqrt(1.0 - correlation**2) * other)
    order = np.argsort(temperature)
    bins = binned(temperature[order], pressure[order])
    for a, b in ((3.0, 0.03), (-4.0, 0.02), (0.0, 0.05), (5.0, 0.0)):
        found = sum(
            share * np.exp(a * value + b * bins.temperature) for value, share in two_pressures(bins)
        )
        exact = np.exp(
            a * mean + 0.5 * (a**2 * s**2 + 2 * a * b * correlation * s * t + b**2 * t**2)
        )
        spread = np.sqrt(np.exp(a**2 * s**2 + 2 * a * b * correlation * s * t + b**2 * t**2) - 1.0)
        assert BIN_AREAS @ found == pytest.approx(
            exact, rel=4 * spread / np.sqrt(z.size) + 3e-3
        )  # width of the bins


def together(*contacts):
    """Bins of contacts at one speed, each with ascending temperatures and pressures of its points."""
    return Bins(
        *(np.array(part)[:, None] for part in zip(*(binned(*c) for c in contacts), strict=True))
    )


def pooled(bins, weight, own, level):
    """One quantile of contacts together: rows (n, speeds), and whether their scatter is known."""
    found = pooled_quantiles(shares_of(bins, weight), own[..., None], np.array([level]))
    return found.rows[..., 0], found.known[..., 0]


def even(low, pressure, count=4000):
    """A contact of one pressure whose temperature is uniform from `low` to 1 above."""
    return low + (np.arange(count) + 0.5) / count, np.full(count, pressure)


@pytest.mark.parametrize(("weight", "cold"), [("heat", 0.5), ("area", 0.75)])
@pytest.mark.parametrize("level", [0.25, 0.6, 0.9, 0.99])
def test_quantiles_of_two_contacts_together_are_closed(weight, cold, level):
    # under the same load the hotter one of three times the pressure has a third of the area, and as much heat
    bins = together(even(0.0, 1e9), even(1.0, 3e9))
    rows, _ = pooled(bins, weight, np.array([[level], [1.0 + level]]), level)
    exact = level / cold if level < cold else 1.0 + (level - cold) / (1.0 - cold)
    assert rows.mean(axis=0) == pytest.approx(exact, abs=1e-3)


@pytest.mark.parametrize("kind", ["temperature_quantile_", "sliding_temperature_quantile_"])
def test_a_sample_pools_quantiles_by_heat_and_by_area_under_their_names(kind):
    bins = together(even(0.0, 1e9), even(1.0, 3e9))
    own = {name: np.array([[level], [1.0 + level]]) for name, level in LEVELS.items()}
    numbers = {f"{kind}{of}{name}": rows for of in ("", "area_") for name, rows in own.items()}
    nothing = np.empty((2, 0))
    sample = Sample(1.0, 8.0, np.arange(2), numbers, np.empty(0), nothing, 1.0, bins=bins)
    for of, cold in ("", 0.5), ("area_", 0.75):
        for name, level in LEVELS.items():
            exact = level / cold if level < cold else 1.0 + (level - cold) / (1.0 - cold)
            rows, _ = catalogue.pooled(sample, f"{kind}{of}{name}")
            assert rows.mean() == pytest.approx(exact, abs=2e-3)


@pytest.mark.parametrize("weight", ["heat", "area"])
def test_alike_contacts_have_their_own_quantiles_without_scatter(weight):
    rng = np.random.default_rng(11)
    one = np.sort(rng.gamma(2.0, 50.0, 300)), rng.gamma(2.0, 1e8, 300)
    for level in P:
        rows, known = pooled(together(*[one] * 3), weight, np.full((3, 1), 123.0), level)
        np.testing.assert_allclose(rows, 123.0, rtol=1e-6)
        assert known.all()


def of_one_temperature(count):
    """Contacts of one temperature each, of an exponential distribution, in random order."""
    temperature = -np.log1p(-(np.arange(count) + 0.5) / count)
    return np.random.default_rng(11).permutation(temperature)


@pytest.mark.parametrize("level", [0.5, 0.9, 0.99])
def test_single_spots_have_the_quantiles_of_a_sample_and_their_error(level):
    # each spot is its own quantile: these average to 1. The exact error is √(p(1 − p)/n)/f, f = 1 − p the density
    n = 4000
    own = of_one_temperature(n)[:, None]
    shape = np.ones((n, 1, BIN_AREAS.size))
    bins = Bins(own[..., None] * shape, 1e9 * shape, 0.0 * shape, 0.0 * shape)
    rows, known = pooled(bins, "heat", own, level)
    assert rows.mean() == pytest.approx(-np.log(1.0 - level), abs=0.02)
    error = np.sqrt(level / (1.0 - level) / n)
    assert rows.std() / np.sqrt(n) == pytest.approx(error, rel=0.1)
    assert known.all()


@pytest.mark.parametrize(("spots", "known"), [(300, False), (500, True)])
def test_a_quantile_beyond_which_lie_too_few_spots_is_unknown(spots, known):
    # 99 % + 2 √(.99 .01/n) is 1 at n = 396
    own = of_one_temperature(spots)[:, None]
    shape = np.ones((spots, 1, BIN_AREAS.size))
    for sign, level in (1.0, 0.99), (-1.0, 0.01):
        bins = Bins(sign * own[..., None] * shape, 1e9 * shape, 0.0 * shape, 0.0 * shape)
        assert pooled(bins, "area", sign * own, level)[1] == known


@pytest.mark.parametrize(("sign", "level"), [(1.0, 0.999), (-1.0, 0.001)])
def test_a_quantile_within_one_pixel_of_one_contact_is_unknown(sign, level):
    # of 20 contacts of 40 pixels one has the hottest: with 1/40 of its area it holds more than .1 % of all
    rng = np.random.default_rng(8)
    contacts = [np.sort(sign * rng.random(40)) for _ in range(20)]
    contacts[7] += sign
    bins = together(*((one, np.full(40, 1e9)) for one in contacts))
    own = np.zeros((20, 1))
    assert not pooled(bins, "area", own, level)[1]
    assert pooled(bins, "area", own, 0.5)[1]


@pytest.mark.parametrize("weight", ["heat", "area"])
def test_quantiles_at_all_levels_are_those_of_sorted_pixels_of_all_contacts(weight):
    rng = np.random.default_rng(8)
    contacts = []
    for _ in range(30):  # under one load the pressure is in proportion to 1 over the area
        size = int(rng.integers(3000, 9000))
        contacts.append(
            (np.sort(rng.gamma(4.0, rng.uniform(1.0, 3.0), size)), np.full(size, 1e13 / size))
        )
    both = np.concatenate(contacts, axis=1)
    own = []
    for values, heat in (*contacts, both[:, np.argsort(both[0])]):
        own.append(weighted_quantiles(values, heat if weight == "heat" else np.ones_like(heat), P))
    exact = own.pop()
    shares = shares_of(together(*contacts), weight)
    found = pooled_quantiles(shares, np.array(own)[:, None], P)
    # the coldest bin has 6 % of the area: half of it is coarse for the first level
    np.testing.assert_allclose(found.rows.mean(axis=0)[0, 1:], exact[1:], rtol=2e-3)


def test_a_share_between_bins_that_ascend_but_for_rounding_is_between_0_and_1():
    above = np.nextafter(1.0, 2.0)
    temperature = np.ones((1, 1, BIN_AREAS.size))
    temperature[..., -8:-3] = above
    shape = np.ones_like(temperature)
    bins = Bins(temperature, 1e9 * shape, 0.0 * shape, 0.0 * shape)
    for at in 1.0, above:
        share = shares_of(bins, "area").colder(np.array([[at]]))
        assert 0.0 < share <= 1.0


@pytest.mark.parametrize("weight", ["heat", "area"])
@pytest.mark.parametrize("level", [0.25, 0.5, 0.9])
def test_influence_values_of_a_pooled_quantile_are_those_of_a_jackknife(weight, level):
    n, rng = 40, np.random.default_rng(8)
    contacts = [even(*pair) for pair in rng.uniform([0.0, 1e9], [2.0, 4e9], (n, 2))]
    own = np.array([[contact[0][0] + level] for contact in contacts])

    def value(chosen):
        bins = together(*(contacts[i] for i in chosen))
        return pooled(bins, weight, own[chosen], level)[0]

    rows = value(np.arange(n))[:, 0]
    without = np.array([value(np.delete(np.arange(n), i)).mean() for i in range(n)])
    error = np.sqrt((n - 1) * np.mean((without - without.mean()) ** 2))
    assert rows.std(ddof=1) / np.sqrt(n) == pytest.approx(error, rel=0.15)
    assert np.corrcoef(rows, -without)[0, 1] > 0.98


STEEL = {"conductivity": 30.0, "diffusivity": 7.6e-6}
FROM_REST = SlideFromRest()


def flash_of_field(pressure, grid, heat, slide=FROM_REST, skin=None):
    """T_flash of the field itself at each speed, K."""
    found = []
    for speed in heat.speeds:
        flux = heat.friction_coefficient * speed * pressure
        field = rs.sliding_temperature(
            flux, grid, speed=speed, **STEEL, skin=skin, **slide._asdict()
        )
        found.append(np.sum(field * pressure) / pressure.sum())
    return np.array(found)


def resting(pressure, grid):
    """The distribution over T_flash."""
    heat = rs.HeatSource([1e-150], friction_coefficient=0.1, **STEEL)
    flash = flash_of_field(pressure, grid, heat) if pressure.any() else np.ones(1)
    found = temperature_distribution(pressure, grid, heat, flash, SlideFromRest())
    return found._replace(by_heat=found.by_heat / flash, by_area=found.by_area / flash)


def test_the_field_at_rest_of_a_hertz_contact_has_its_quantiles():
    # the periodic cell shifts the temperature within the contact by one number, up to (R/L)³
    pressure = 1e9 * hertz(240, 5.0)[1]
    found = resting(pressure, rs.Grid((240, 240), (10e-4, 10e-4)))
    for weight, quantiles in (("heat", found.by_heat[0]), ("area", found.by_area[0])):
        exact = of_hertz(weight)
        span = (quantiles - quantiles[0]) / (quantiles[4] - quantiles[0])
        np.testing.assert_allclose(span, (exact - exact[0]) / (exact[4] - exact[0]), atol=0.01)
    assert found.by_heat[0, 2] > found.by_area[0, 2]  # more heat is set free at the hot centre


def test_temperatures_are_in_proportion_to_their_heat_weighted_mean():
    rng = np.random.default_rng(11)
    grid = rs.Grid((64, 64), (1e-3, 1e-3))
    pressure = np.maximum(rng.standard_normal(grid.shape), 0.0)
    heat = rs.HeatSource([0.5, 20.0], friction_coefficient=0.1, **STEEL)
    flashes = flash_of_field(pressure, grid, heat, SlideFromRest(0.3, 1e-4)) * [0.7, 1.6]
    found = temperature_distribution(pressure, grid, heat, flashes, SlideFromRest(0.3, 1e-4))
    for k, (speed, flash) in enumerate(zip([0.5, 20.0], flashes, strict=True)):
        field = rs.sliding_temperature(
            pressure,
            grid,
            speed=speed,
            conductivity=1.0,
            diffusivity=7.6e-6,
            direction=0.3,
            slid_distance=1e-4,
        )
        values, weights = sorted_contact(field, pressure)
        scaled = values * flash * weights.sum() / (values @ weights)
        np.testing.assert_allclose(
            found.by_heat[k], weighted_quantiles(scaled, weights, P), rtol=1e-4
        )
        np.testing.assert_allclose(
            found.by_area[k], np.quantile(scaled, P, method="hazen"), rtol=1e-4
        )
        assert BIN_AREAS @ found.bins.temperature[k] == pytest.approx(scaled.mean(), rel=1e-4)


def rough_contact(points):
    grid = rs.Grid((points, points), (1e-3, 1e-3))
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        0.2, hurst=0.8, q_min=2.5e4, q_max=np.pi * points / 2e-3
    )
    heights = rs.synthesize(spectrum, grid, np.random.default_rng(8))
    solid = rs.Solid(110e9, 3e9)
    return rs.solve_contact(
        heights, grid, solid, nominal_pressure=3e8, tolerance=1e-4
    ).pressure, grid


def test_single_precision_errs_by_less_than_a_hundred_thousandth_of_the_flash_temperature():
    pressure, grid = rough_contact(256)
    speeds, skin = [0.01, 1.0, 100.0], rs.Skin(thickness=3e-7, conductivity=2.0, diffusivity=1e-6)
    heat = rs.HeatSource(speeds, friction_coefficient=0.1, **STEEL, skin=skin)
    flashes = flash_of_field(pressure, grid, heat, skin=skin)
    found = temperature_distribution(pressure, grid, heat, flashes, SlideFromRest())
    for k, speed in enumerate(speeds):
        field = rs.sliding_temperature(
            pressure, grid, speed=speed, conductivity=30.0, diffusivity=7.6e-6, skin=skin
        )
        values, weights = sorted_contact(field, pressure)
        values *= weights.sum() / (values @ weights)
        shares = (np.cumsum(weights) - 0.5 * weights) / weights.sum()
        by_heat, by_area = found.by_heat[k] / flashes[k], found.by_area[k] / flashes[k]
        np.testing.assert_allclose(by_heat, np.interp(P, shares, values), rtol=0.0, atol=1e-5)
        np.testing.assert_allclose(
            by_area, np.quantile(values, P, method="hazen"), rtol=0.0, atol=1e-5
        )


@pytest.mark.slow
def test_fields_of_many_points_are_those_of_each_speed_alone():
    # the responses of 1024² points are kept for two speeds, not for three
    grid = rs.Grid((1024, 1024), (1e-3, 1e-3))
    pressure = np.maximum(np.random.default_rng(11).standard_normal(grid.shape), 0.0)
    speeds = (0.5, 0.0, 20.0)

    def distribution(some):
        heat = rs.HeatSource(some, friction_coefficient=0.1, **STEEL)
        flashes = flash_of_field(pressure, grid, heat, SlideFromRest(0.3, 1e-4))
        return temperature_distribution(
            pressure, grid, heat, flashes, SlideFromRest(0.3, 1e-4)
        ).by_heat

    together = distribution(speeds)
    assert np.isfinite(together).all()
    for _ in range(2):  # computed, and kept
        np.testing.assert_array_equal(
            np.concatenate([distribution([speed]) for speed in speeds]), together
        )


def test_full_contact_has_normal_temperatures():
    # T is a sum of many waves; weighted by heat 1 + cz the quantile z has Φ(z) − cφ(z) = p
    grid = rs.Grid((256, 256), (1.0, 1.0))
    spectrum = rs.SelfAffineSpectrum.from_rms_slope(
        0.05, hurst=0.3, q_min=12 * np.pi, q_max=120 * np.pi
    )
    heights = rs.synthesize(spectrum, grid, np.random.default_rng(4))
    contact = rs.solve_contact(heights, grid, rs.Solid(1.0), nominal_pressure=0.2, tolerance=1e-8)
    assert contact.contact_fraction == 1.0
    found = resting(contact.pressure, grid)
    field = rs.sliding_temperature(
        contact.pressure, grid, speed=0.0, conductivity=1.0, diffusivity=1.0
    )
    covariance = float(np.mean(field * contact.pressure)) / 0.2  # T_flash
    deviation = float(field.std())
    c = covariance / deviation
    normal = scipy.stats.norm
    exact = [
        scipy.optimize.brentq(lambda z, p=p: normal.cdf(z) - c * normal.pdf(z) - p, -5.0, 5.0)
        for p in P
    ]
    errors = np.array(
        [0.12] * 6 + [0.3]
    )  # of ten thousand spots; one in a thousand is hotter than the last
    assert np.all(np.abs(found.by_heat[0] * c - exact) < errors)
    assert np.all(np.abs(found.by_area[0] * c - normal.ppf(P)) < errors)
    assert np.abs(found.by_heat[0] - found.by_area[0]).min() * c > 0.5 * c


@pytest.mark.parametrize(
    ("factor", "known"),
    [(1.0, True), (0.65, True), (1.6, True), (0.55, False), (1.7, False), (-1.0, False)],
)
def test_a_field_of_another_flash_temperature_is_unknown(factor, known):
    pressure, grid = rough_contact(64)
    friction, speeds, slide = [0.1, 0.3], [0.1, 2.0], SlideFromRest(1.0)
    conductivity = [15.0, 60.0]
    source = {"heat_partition": 0.8, "diffusivity": 7.6e-6}
    flashes = []
    for mu, speed, kappa in zip(friction, speeds, conductivity, strict=True):
        flux = 0.8 * mu * speed * pressure
        field = rs.sliding_temperature(
            flux,
            grid,
            speed=speed,
            conductivity=kappa,
            diffusivity=7.6e-6,
            direction=slide.direction,
        )
        flashes.append(np.sum(field * pressure) / pressure.sum())
    heat = rs.HeatSource(speeds, friction_coefficient=friction, conductivity=conductivity, **source)
    found = temperature_distribution(pressure, grid, heat, np.array(flashes) * [factor, 1.0], slide)
    assert np.isfinite(found.by_heat[1]).all()
    for values in (found.by_heat[0], found.by_area[0], found.bins.temperature[0]):
        assert np.isfinite(values).all() if known else np.isnan(values).all()


def test_without_contact_there_is_no_temperature():
    found = resting(np.zeros((16, 16)), rs.Grid((16, 16), (1e-3, 1e-3)))
    assert np.isnan(found.by_heat).all()
    assert np.isnan(found.by_area).all()
    assert all(np.isnan(values).all() for values in found.bins)
