"""The temperature over a clipped field: waves by time integrals, normal fields, closed statistics, solved steel."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri
from yielding_cases import MODULUS, SelfAffine

from theory import clipped, flash, plasticity
from theory.clipped.drawing import (
    Cell,
    amplitudes,
    draw_pressure,
    halved,
    heat_response,
    temperature,
)
from theory.clipped.temperatures import Drawn, continued

STEEL = {"effective_modulus": 1.0989e11, "nominal_pressure": 9e7, "penetration_hardness": 1.2e9}
HEAT = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": 7.6e-6}
SHARES = (0.05, 0.25, 0.5, 0.75, 0.9, 0.99, 0.999)
EV = 1.602176634e-19


class Steel(SelfAffine):
    """C(q) of both faces of two rough steels."""

    def __init__(self, q_max=4.15e7):
        super().__init__(level=1.0, q_min=6350.0, q_max=q_max)

    @property
    def breaks(self):
        return (6350.0, 9.4e4, self.q_max)

    def __call__(self, q):
        # h_rms = .9 µm of each face: ⟨h²⟩ = 2π ∫ q C dq, over the unit spectrum
        return 2 * (9e-7) ** 2 / UNIT_SQUARE * shape(q)


def shape(q):
    r = np.asarray(q) / 9.4e4
    return np.where(r < 1.0, r**-1.5, np.maximum(r, 1.0) ** -3.6)


UNIT_SQUARE = (
    2
    * np.pi
    * sum(quad(lambda q: q * shape(q), *ends)[0] for ends in ((6350.0, 9.4e4), (9.4e4, 4.15e7)))
)


def half_contact():
    """Contact on half of the area with ρ = e^(−r²/2): ⟨FF′⟩ − ¼ = arcsin ρ/2π."""
    r = np.exp(np.arange(-2048, 2048) * 4e-3 + 2e-3)
    steps = np.array([0.0]), np.array([1.0])
    of_half = np.arcsin(np.exp(-(r**2) / 2)) / (2 * np.pi)
    return clipped.ClippedField(*steps, r, of_half, 0.25, clipped.products(*steps))


@pytest.mark.parametrize(
    ("mode", "speed"), [((1, 2), 0.0), ((3, 0), 5.0), ((-2, 4), 0.7), ((0, 1), 50.0)]
)
@pytest.mark.parametrize("way", [1e-5, 3e-4])
def test_the_response_of_a_wave_is_the_time_integral_of_its_decay(mode, speed, way):
    # heat of the time τ ago: √(D/πτ) e^(−Dq²τ), and the source has moved on by vτ
    cell, diffusivity = Cell(16, 1e-3), 7.6e-6
    response = heat_response(cell, speed, diffusivity, way)[mode]
    along, across = (2 * np.pi * n / 1e-3 for n in mode)
    square = along**2 + across**2
    if speed == 0.0:
        assert response == pytest.approx(1 / np.sqrt(square), rel=1e-12)
        return

    def part(u, factor):  # τ = u²
        return (
            2
            * np.sqrt(diffusivity / np.pi)
            * np.exp(-diffusivity * square * u**2)
            * factor(along * speed * u**2)
        )

    end = np.sqrt(way / speed)
    real, imaginary = (
        quad(part, 0, end, args=(f,), limit=400, epsabs=1e-13)[0] for f in (np.cos, np.sin)
    )
    assert response == pytest.approx(real + 1j * imaginary, rel=1e-8)
    steady = heat_response(cell, speed, diffusivity)[mode]
    assert steady**-2 == pytest.approx(square - 1j * along * speed / diffusivity, rel=1e-12)


def test_a_source_is_followed_by_its_heat():
    cell = Cell(64, 1.0)
    x = np.arange(64) / 64
    source = np.ones((64, 64)) * (1 + np.cos(2 * np.pi * x))[:, None]
    hot = temperature(source, heat_response(cell, 5.0, 0.1))
    assert hot.mean() == pytest.approx(0.0, abs=1e-15)
    rate = np.sqrt((2 * np.pi) ** 2 - 2j * np.pi * 5.0 / 0.1)
    assert hot[:, 3] == pytest.approx((np.exp(2j * np.pi * x) / rate).real, abs=1e-14)
    assert 32 < hot[:, 0].argmax() < 64  # behind the crest at 0


def test_the_shortest_wave_along_sliding_has_a_real_response():
    cell = Cell(8, 1.0)
    response = heat_response(cell, 5.0, 0.1)
    q = 2 * np.pi * np.hypot(4, np.arange(5))  # it runs both ways: the mean of both
    both = [1 / np.sqrt(q**2 - sign * 2j * np.pi * 4 * 5.0 / 0.1) for sign in (-1, 1)]
    assert response[4] == pytest.approx((both[0] + both[1]) / 2, rel=1e-12)
    assert np.abs(heat_response(Cell(9, 1.0), 5.0, 0.1)[1:].imag).min() > 0.0
    assert response[0, 0] == 0.0


def test_the_waves_of_a_gaussian_correlation_have_its_transform_as_their_variance():
    cell = Cell(64, 16.0)
    amplitude, wrong = amplitudes(half_contact(), cell)
    q = 2 * np.pi * np.fft.fftfreq(64, 0.25)
    variance = 2 * np.pi / 16.0**2 * np.exp(-(q[:, None] ** 2 + q**2) / 2)
    variance[0, 0] = 0.0
    # waves as long as infinity, 2 % of the variance, are left out of z and of the pressure
    assert amplitude**2 == pytest.approx(variance / variance.sum(), abs=1.5e-4)
    assert wrong < 3e-4  # the table of angles
    assert (amplitude**2).sum() == pytest.approx(1.0, rel=1e-12)


def test_light_contacts_have_nearly_the_power_of_the_law():
    # contacts avoid one another more than a Gaussian field can
    solid = {**STEEL, "nominal_pressure": 1.2e7}
    spectrum = SelfAffine(level=1e-24, q_max=6.4e5)
    field = clipped.clipped_field(spectrum, **solid)
    cell = Cell(128, 4 * 2 * np.pi / 5e4)
    amplitude, wrong = amplitudes(field, cell)
    assert (amplitude**2).sum() == pytest.approx(1.0, rel=1e-12)
    assert 0.05 < wrong < 0.15
    rng = np.random.default_rng(2)
    along, across = np.meshgrid(*(2 * np.pi * np.fft.fftfreq(128, cell.length / 128),) * 2)
    q = np.hypot(along, across)
    powers = [
        np.abs(np.fft.fft2(draw_pressure(field, amplitude, rng.standard_normal(amplitude.shape))))
        ** 2
        for _ in range(30)
    ]
    drawn = np.mean(powers, axis=0)
    drawn[0, 0] = 0.0
    stress = plasticity.stress_spectrum(spectrum, **solid)
    law = stress(np.where(q > 0, q, q.max()))
    law[0, 0] = 0.0
    bands = [(q > low) & (q <= 2 * low) for low in 5e4 * 2.0 ** np.arange(-1, 4)]
    found, expected = (
        np.array([power[band].sum() for band in bands]) / power.sum() for power in (drawn, law)
    )
    # waves beyond those of the grid count on it too, and 30 fields scatter
    assert np.abs(found - expected).sum() / 2 < wrong + 0.04


def test_drawn_contacts_have_the_load_and_the_correlation_of_the_field():
    field, cell = half_contact(), Cell(128, 32.0)
    amplitude, _ = amplitudes(field, cell)
    rng = np.random.default_rng(1)
    drawn = np.stack(
        [draw_pressure(field, amplitude, rng.standard_normal(amplitude.shape)) for _ in range(12)]
    )
    assert drawn.mean(axis=(1, 2)).tolist() == [0.5] * 12
    assert set(drawn.ravel()) == {0.0, 1.0}
    shift = np.array([4, 6, 8])  # r = 1, 1.5, 2
    both = np.array(
        [[(d * np.roll(d, n, axis)).mean() for n in shift for axis in (0, 1)] for d in drawn]
    )
    expected = 0.25 + np.arcsin(np.exp(-((shift * 0.25) ** 2) / 2)) / (2 * np.pi)
    error = both.std(axis=0) / np.sqrt(12)
    assert (np.abs(both.mean(axis=0) - expected.repeat(2)) < 4 * error + 1e-3).all()


def sample(ratio, pressure, field, hot=100.0):
    ratio, pressure = np.atleast_2d(np.asarray(ratio, float)), np.asarray(pressure, float)
    scaled = ratio / (ratio @ pressure / pressure.sum())[:, None]
    return clipped.TemperatureDistribution(
        np.full(len(ratio), hot), 0.25, scaled, pressure, np.asarray(field), 0.0
    )


def test_quantiles_of_few_points_are_linear_between_the_middles_of_their_weights():
    found = sample([0.5, 1.5, 0.0, 2.0], [1.0, 1.0, 1.0, 1.0], [0, 0, 1, 1])
    assert found.quantiles([0.125, 0.375, 0.5, 0.875, 1.0]).value[:, 0] == pytest.approx(
        [0, 50, 100, 200, 200]
    )
    # heat 3 : 1, at T/T_flash ⅔ and 2
    uneven = sample([1.0, 3.0] * 2, [3.0, 1.0] * 2, [0, 0, 1, 1])
    assert uneven.quantiles([0.375, 0.875]).value[:, 0] == pytest.approx([200 / 3, 200])
    assert uneven.quantiles([0.25, 0.75], by="area").value[:, 0] == pytest.approx([200 / 3, 200])


def test_means_over_two_temperatures_are_closed():
    found = sample([1.0, 3.0] * 2, [3.0, 1.0] * 2, [0, 0, 1, 1])  # T/T_flash is ⅔ and 2
    assert found.deviation().value == pytest.approx([100 * np.sqrt(0.75 * (1 / 3) ** 2 + 0.25)])
    assert found.deviation(by="area").value == pytest.approx([200 / 3])
    assert found.share_above(100.0).value == pytest.approx([0.25])
    assert found.share_above(100.0, by="area").value == pytest.approx([0.5])
    energies = np.array([0.0, 0.6, 1.5]) * EV
    conditions = {"background_temperature": 500.0, "heat_partition": 0.5}
    kelvin = 500.0 + 0.5 * np.array([200 / 3, 200])
    barrier = energies[:, None] - np.array([3.0, 1.0]) * 1e-20
    rate = found.reaction_rate(energies, prefactor=1e13, activation_volume=1e-20, **conditions)
    mean = np.exp(-barrier / (clipped.BOLTZMANN * kelvin)).mean(axis=1)
    assert rate.value[:, 0] == pytest.approx(0.25 * 1e13 * mean, rel=1e-12)
    still = found.reaction_rate(energies, prefactor=1e13, **conditions)
    assert still.value[0, 0] == pytest.approx(0.25 * 1e13, rel=1e-14)  # E = 0
    assert still.standard_error[0, 0] == 0.0


@pytest.mark.parametrize("volume", [0.0, 1e-20, -3e-20])
def test_at_the_activation_temperature_the_same_pressures_react_as_fast(volume):
    # two thirds of the contact have T/T_flash = 7/9, the rest 7/3
    found = sample([1.0, 1.0, 3.0] * 2, [3.0, 3.0, 1.0] * 2, [0, 0, 0, 1, 1, 1])
    energies = np.array([0.0, 0.6, 1.5]) * EV
    active = found.activation_temperature(
        energies, background_temperature=500.0, heat_partition=0.5, activation_volume=volume
    ).value[:, 0]
    kelvin = 500.0 + 50.0 * np.array([7 / 9, 7 / 9, 7 / 3])
    released = volume * np.array([3.0, 3.0, 1.0]) - energies[:, None]
    even, uneven = (
        np.exp(released / (clipped.BOLTZMANN * t)).mean(axis=1) for t in (active[:, None], kelvin)
    )
    chosen = slice(None) if volume < 0.0 else slice(1, None)
    assert even[chosen] == pytest.approx(uneven[chosen], rel=1e-10)
    assert np.isnan(active[0]) == (volume >= 0.0)  # without a barrier


def test_an_even_contact_reacts_at_its_own_temperature():
    found = sample([1.0, 1.0, 1.0], [1.0, 2.0, 3.0], [0, 1, 1])
    active = found.activation_temperature([0.1 * EV, 20 * EV], background_temperature=300.0)
    assert active.value[:, 0] == pytest.approx(400.0, rel=1e-12)
    assert active.standard_error[:, 0] == pytest.approx(0.0, abs=1e-9)


def test_the_activation_temperature_of_a_low_barrier_is_the_mean_of_the_inverse():
    # ⟨1/T⟩⁻¹ as E → 0; the next term is of first order in E
    found = sample([0.5, 1.0, 1.5], [1.0, 1.0, 1.0], [0, 1, 2])
    kelvin = 300.0 + 100.0 * np.array([0.5, 1.0, 1.5])
    harmonic = 1 / (1 / kelvin).mean()
    energy = np.array([1e-3, 2e-3]) * EV
    rise = found.activation_temperature(energy, background_temperature=300.0).value[:, 0] - harmonic
    assert rise[1] / rise[0] == pytest.approx(2.0, rel=1e-3)
    assert 0.0 < rise[0] < 0.1


def test_the_error_of_a_share_is_that_of_the_mean_over_equal_fields():
    rng = np.random.default_rng(5)
    hot = rng.uniform(size=(20, 50)) < rng.uniform(0.2, 0.4, (20, 1))
    ratio = np.where(hot, 3.0, 1.0)
    found = sample(ratio.ravel(), np.ones(1000), np.arange(20).repeat(50))
    # a limit that no rescaling passes
    share = found.share_above(100 * found.ratio.mean())
    assert share.value == pytest.approx(hot.mean())
    assert share.standard_error == pytest.approx(
        hot.mean(axis=1).std(ddof=1) / np.sqrt(20), rel=1e-12
    )


def test_without_one_of_two_fields_the_other_has_its_own_flash_temperature():
    # T/T_flash of the first alone is ½ and 3/2, of the second 1; two fields err by half of their difference
    found = sample([1.0, 3.0, 5.0, 5.0], [1.0, 1.0, 2.0, 2.0], [0, 0, 1, 1])
    assert found.quantiles(0.25).standard_error == pytest.approx(25.0)
    assert found.deviation().standard_error == pytest.approx(25.0)
    assert found.share_above(120.0).standard_error == pytest.approx(0.25)
    conditions = {"background_temperature": 500.0, "heat_partition": 0.5}
    energy = 0.6 * EV
    rates = [
        np.exp(-energy / (clipped.BOLTZMANN * (500.0 + np.array(x)))).mean()
        for x in ([25.0, 75.0], [50.0])
    ]
    rate = found.reaction_rate(energy, **conditions)
    assert rate.standard_error / rate.value == pytest.approx(
        abs(np.log(rates[0] / rates[1])) / 2, rel=1e-9
    )
    active = [-energy / (clipped.BOLTZMANN * np.log(rate)) for rate in rates]
    error = found.activation_temperature(energy, **conditions).standard_error
    assert error == pytest.approx(
        abs(active[0] - active[1]) / 2, rel=0.03
    )  # linear in ln of the rate


def test_points_below_absolute_zero_do_not_react():
    found = sample([-4.0, 6.0] * 2, [1.0, 1.0] * 2, [0, 0, 1, 1])  # T/T_flash is −4 and 6
    rate = found.reaction_rate([0.0, 0.6 * EV], background_temperature=300.0).value[:, 0]
    assert rate == pytest.approx(
        [0.25, 0.125 * np.exp(-0.6 * EV / (clipped.BOLTZMANN * 900.0))], rel=1e-12
    )


def test_in_full_contact_pressure_and_temperature_are_jointly_normal():
    spectrum = SelfAffine(level=1e-29, q_max=1e6)
    solid = {"effective_modulus": MODULUS, "nominal_pressure": 0.5e11, "penetration_hardness": 1e11}
    speed = 0.02
    found = clipped.temperature_distribution(
        speed, spectrum, **solid, **HEAT, fields=6, points=256, seed=3
    )
    assert found.contact_fraction == pytest.approx(1.0, abs=1e-9)
    assert found.ratio.shape == (1, 6 * 256**2)
    assert found.field.tolist() == np.arange(6).repeat(256**2).tolist()
    stress = plasticity.stress_spectrum(spectrum, **solid)
    # over T_flash; waves of the drawn fields end at 32 q_min/2
    law = {"stress_spectrum": stress, "nominal_pressure": 0.5e11, **HEAT}
    over = float(flash.rms_temperature(speed, **law) / flash.flash_temperature(speed, **law))
    spread = found.deviation(by="area")
    assert spread.value / found.flash_temperature == pytest.approx(over, rel=0.05)
    deviation = float((found.ratio[0] - found.ratio[0].mean()).std())
    shares = np.array([0.05, 0.25, 0.5, 0.75, 0.95])
    even = found.quantiles(shares, by="area")
    expected = deviation * ndtri(shares) * found.flash_temperature
    assert (
        np.abs(even.value[:, 0] - expected)
        < 4 * even.standard_error[:, 0] + 0.01 * abs(expected[0])
    ).all()
    # the heat σ tilts the normal density by 1 + T T_flash/s², of the mean T_flash: Φ(x) − (T_flash/s) φ(x)
    tilted = [
        brentq(
            lambda x, p=p: ndtr(x) - np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi) / deviation - p, -6, 6
        )
        for p in shares
    ]
    heated = found.quantiles(shares)
    wanted = deviation * np.array(tilted) * found.flash_temperature
    assert (
        np.abs(heated.value[:, 0] - wanted)
        < 4 * heated.standard_error[:, 0] + 0.01 * abs(expected[0])
    ).all()


def test_steel_has_the_quantiles_and_the_rates_of_solved_contacts():
    found = clipped.temperature_distribution([1.0, 35.0], Steel(q_max=2.032e5), **STEEL, **HEAT)
    assert found.contact_fraction == pytest.approx(9e7 / 1.2e9, rel=0.01)  # nearly all has yielded
    over = found.quantiles(SHARES)
    # of boundary-element contacts, all heat in the body: slow and fast
    solved = [
        (0.26, 0.64, 0.96, 1.31, 1.67, 2.28, 2.55),
        (0.04, 0.55, 0.96, 1.41, 1.83, 2.58, 3.06),
    ]
    ratio = (over.value / found.flash_temperature).T
    error = (over.standard_error / found.flash_temperature).T
    assert (np.abs(ratio - solved) < 3 * error + 0.06).all()
    energies = np.array([0.6, 1.0, 1.5]) * EV
    share = 225.0 / found.flash_temperature[1]  # they were solved at 225 K
    rate = found.reaction_rate(energies, background_temperature=700.0, heat_partition=share)
    at_flash = np.exp(-energies / (clipped.BOLTZMANN * 925.0))
    excess = rate.value[:, 1] / found.contact_fraction / at_flash
    assert excess == pytest.approx([1.5, 3.2, 12.0], rel=0.15)


def test_the_hottest_of_all_steel_is_that_of_a_ladder_of_solved_contacts():
    # boundary-element contacts have 99 % quantiles of 2.43 and 2.72 T_flash at 8e5 1/m, and they rise by .06 more
    found = clipped.temperature_distribution([1.0, 35.0], Steel(), **STEEL, **HEAT)
    assert found.contact_fraction == pytest.approx(9e7 / 1.2e9, rel=1e-3)  # all has yielded
    hottest = found.quantiles(0.99)
    ratio, error = (values[0] / found.flash_temperature for values in hottest)
    assert (np.abs(ratio - [2.49, 2.77]) < 3 * error).all()
    assert (error < 0.06).all()
    assert found.ratio @ found.pressure / found.pressure.sum() == pytest.approx(
        [1.0, 1.0], rel=1e-12
    )


def test_fields_end_at_the_wave_of_four_pixels():
    # four longest waves on 128 points: that is 8 q_min
    some = {**STEEL, **HEAT, "fields": 2, "points": 128}
    whole, part = (
        clipped.temperature_distribution(3.0, SelfAffine(level=1e-24, q_max=end * 5e4), **some)
        for end in (16, 8)
    )
    assert whole.pressure == pytest.approx(part.pressure, rel=1e-9)
    assert not np.allclose(whole.ratio, part.ratio, rtol=1e-3)  # it goes on


def test_temperatures_go_on_in_proportion_to_the_flash_temperature():
    pressure, field = np.array([1.0, 1.0, 2.0]), np.array([0, 1, 1])
    fine = Drawn(
        np.array([80.0, 8.0]), np.array([[0.2, 1.4, 1.2], [0.6, 1.0, 1.2]]), pressure, field, 0.0
    )
    coarse = Drawn(
        np.array([100.0, 8.0]), np.array([[0.4, 1.2, 1.2], [1.0, 1.0, 1.0]]), pressure, field, 0.0
    )
    found = continued(fine, coarse, np.array([70.0, 7.0]))
    # half a step more; middles of the shares of heat are ⅛, ⅞ and ½, of the coarse ones ⅛, ⅜ and ¾
    first = np.array([16.0, 112.0, 96.0])
    below = np.array([40.0, 120.0, 120.0])
    assert found[0] == pytest.approx((first + 0.5 * (first - below)) / 70.0, rel=1e-12)
    assert found[1] == pytest.approx(fine.ratio[1], rel=1e-12)  # no step is known
    furthest = continued(fine, coarse, np.array([10.0, 7.0]))[0]
    limited = first + 2.0 * (first - below)
    assert furthest == pytest.approx(limited / (limited @ pressure / 4.0), rel=1e-12)
    back = continued(fine, coarse, np.array([90.0, 7.0]))[0]
    assert back == pytest.approx(fine.ratio[0], rel=1e-12)


@pytest.mark.parametrize(("points", "fewer"), [(64, 32), (50, 25), (33, 16)])
def test_noise_on_fewer_points_has_the_same_long_waves(points, fewer):
    white = np.random.default_rng(4).standard_normal((points, points))
    coarse = halved(white)
    assert coarse.shape == (fewer, fewer)
    waves, expected = np.fft.fft2(coarse) / fewer, np.fft.fft2(white) / points
    for n in range((1 - fewer) // 2 + 1, fewer // 2):
        for m in range((1 - fewer) // 2 + 1, fewer // 2):
            assert waves[n, m] == pytest.approx(expected[n, m], abs=1e-12)


def test_speeds_keep_their_order_and_seeds_their_fields():
    small = {"spectrum": SelfAffine(level=1e-24), **STEEL, **HEAT, "fields": 2, "points": 128}
    one = clipped.temperature_distribution([3.0, -0.1, 0.0], **small)
    again = clipped.temperature_distribution([0.1, 3.0], **small)
    other = clipped.temperature_distribution(3.0, **small, seed=1)
    assert one.ratio[:2].tolist() == again.ratio[::-1].tolist()
    assert other.ratio[0, 0] != one.ratio[0, 0]
    assert one.flash_temperature[2] == 0.0
    assert one.quantiles(0.5).value[0, 2] == 0.0
    # a way beyond half of the cell counts as that half
    far = clipped.temperature_distribution(3.0, **small, slid_distance=1.0)
    assert far.ratio[0] == pytest.approx(one.ratio[0], rel=1e-9)
    near = clipped.temperature_distribution(3.0, **small, slid_distance=1e-5)
    assert near.deviation().value < far.deviation().value


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"fields": 1}, "fields = 1 must be a whole number of 2 or more"),
        ({"points": 32}, "points = 32"),
        ({"seed": -1}, "seed = -1"),
        ({"slid_distance": 0.0}, "slid_distance = 0 m"),
        ({"penetration_hardness": 1e6}, "exceeds the penetration_hardness"),
    ],
)
def test_a_distribution_that_cannot_be_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        clipped.temperature_distribution(
            1.0, **{"spectrum": SelfAffine(), **STEEL, **HEAT, **changes}
        )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda d: d.quantiles(1.5), "shares = 1.5"),
        (lambda d: d.quantiles(0.5, by="volume"), "by = 'volume'"),
        (lambda d: d.reaction_rate(-1.0, background_temperature=300.0), "activation_energy"),
        (
            lambda d: d.activation_temperature(-EV, background_temperature=300.0),
            "activation_energy",
        ),
        (lambda d: d.reaction_rate(EV, background_temperature=-1.0), "background_temperature"),
        (
            lambda d: d.reaction_rate(EV, background_temperature=300.0, prefactor=0.0),
            "prefactor = 0 1/s",
        ),
    ],
)
def test_a_question_without_an_answer_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call(sample([-1.0, 4.0], [1.0, 1.0], [0, 1]))


def test_the_doubt_of_fields_falls_with_the_speed():
    # from .24 of a slow source by .02 for each factor e, to .06
    found = clipped.form_doubt([0.0, 1e-3, 1.0, np.e, np.e**2, 1e6])
    np.testing.assert_allclose(found, [0.24, 0.24, 0.17, 0.15, 0.13, 0.06], rtol=1e-12)
    # v h_rms/(D h′), of a plateau to 1e5 and q^(−3.6) up to 8e5 1/m
    spectrum = SelfAffine(level=1e-24, q_max=8e5)
    squares = [quad(lambda q, n=n: q**n * spectrum(q), 5e4, 8e5, points=[1e5])[0] for n in (1, 3)]
    speeds = np.array([0.3, 3.0])
    found = clipped.temperature_distribution(speeds, spectrum, **STEEL, **HEAT, fields=2, points=64)
    peclet = speeds / HEAT["diffusivity"] * np.sqrt(squares[0] / squares[1])
    np.testing.assert_allclose(found.doubt, 0.17 - 0.02 * np.log(peclet), rtol=1e-3)


def test_a_doubted_distribution_is_evener_on_one_side_or_hotter():
    plain = sample([0.36, 0.75, 1.0, 1.49, 1.4], [1.0, 1.0, 1.0, 1.0, 1.0], [0, 0, 0, 1, 1])
    hot, cold, warm = replace(plain, doubt=np.array([0.2])).doubted()
    x = plain.ratio[0] - 1.0
    nearer = np.sign(x) * (np.abs(x) - 0.2 * np.abs(x) ** 1.5)
    np.testing.assert_allclose(hot.ratio[0] - 1.0, np.where(x > 0.0, nearer, x), rtol=1e-12)
    np.testing.assert_allclose(cold.ratio[0] - 1.0, np.where(x < 0.0, nearer, x), rtol=1e-12)
    np.testing.assert_allclose(warm.flash_temperature, 128.0)  # 1 + 1.4 · .2
    # further from T_flash than 4/9/doubt² all points come to the same place
    far = (
        replace(sample([0.0, 40.0, 60.0], [98.0, 1.0, 1.0], [0, 0, 0]), doubt=0.5)
        .doubted()[0]
        .ratio[0]
    )
    np.testing.assert_allclose(far[1:], 1.0 + 16 / 9 - 0.5 * (16 / 9) ** 1.5, rtol=1e-12)
    for same in plain.doubted():  # of solved contacts nothing is in doubt
        np.testing.assert_array_equal(same.ratio, plain.ratio)
        np.testing.assert_array_equal(same.flash_temperature, plain.flash_temperature)
