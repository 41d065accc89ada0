"""The temperature over two drawn faces that slide: exact waves, exchange of bodies, frozen contact, slid steel."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ndtr, ndtri
from yielding_cases import MODULUS, SelfAffine

from theory import clipped, flash, plasticity
from theory.clipped.drawing import Cell
from theory.clipped.two_faces import LAST, Body, Pair, Way, oblique_way, pressures

STEEL = {"effective_modulus": 1.0989e11, "nominal_pressure": 9e7, "penetration_hardness": 1.2e9}
BODY = {"conductivity": 30.0, "diffusivity": 7.6e-6}
SHARES = (0.05, 0.25, 0.5, 0.75, 0.9, 0.99, 0.999)
INSULATING = 1e-4


class Steel(SelfAffine):
    """C(q) of both faces of two rough steels, h_rms = .9 µm each, up to a wave of the slides."""

    def __init__(self, q_max=1.016e5):
        super().__init__(level=1.0, q_min=6350.0, q_max=q_max)

    @property
    def breaks(self):
        return tuple(sorted({6350.0, min(9.4e4, self.q_max), self.q_max}))

    def __call__(self, q):
        return 2 * (9e-7) ** 2 / UNIT_SQUARE * shape(q)


def shape(q):
    r = np.asarray(q) / 9.4e4
    return np.where(r < 1.0, r**-1.5, np.maximum(r, 1.0) ** -3.6)


UNIT_SQUARE = (
    2
    * np.pi
    * sum(quad(lambda q: q * shape(q), *ends)[0] for ends in ((6350.0, 9.4e4), (9.4e4, 4.15e7)))
)


def even_way(steps, cell):
    """Steps of a pixel along x."""
    along = np.arange(1, steps + 1)
    return Way(np.stack([along, 0 * along], axis=1), np.full(steps, cell.length / cell.points))


def at_the_end(waves, way, cell, **bodies):
    pair = Pair(cell, way, 1, **bodies)
    for plane in waves:
        surface = pair.advance(plane[None].astype(np.float32))
    return surface[0]


@pytest.mark.parametrize("speed", [0.003, 0.3, 30.0])
def test_a_wave_through_a_body_that_takes_all_heat_is_the_time_integral_of_its_decay(speed):
    # σ/σ₀ = 1 + ½ cos qx stands in the frame of the resting body: T of the heat of the time τ ago has moved by −vτ
    cell, steps, diffusivity = Cell(64, 1e-3), 200, 7.6e-6
    way, pixel = even_way(steps, cell), 1e-3 / 64
    q = 2 * 2 * np.pi / 1e-3
    x = np.arange(64) * pixel
    plane = 1 + 0.5 * np.cos(q * x)[:, None] * np.ones(64)
    moving, resting = Body(30.0, diffusivity), Body(INSULATING, 1e-6)
    found = at_the_end([plane] * steps, way, cell, speed=speed, moving=moving, resting=resting)

    def part(u, factor):  # τ = u², with the heat of the way slid
        return (
            2
            * np.sqrt(diffusivity / np.pi)
            * np.exp(-diffusivity * q**2 * u**2)
            * factor(q * speed * u**2)
        )

    end = np.sqrt(steps * pixel / speed)
    real, imaginary = (
        quad(part, 0, end, args=(f,), limit=800, epsabs=1e-14)[0] for f in (np.cos, np.sin)
    )
    # a source that moves towards +x in the body leaves its heat behind, at x < 0
    expected = 0.5 * (real * np.cos(q * x) - imaginary * np.sin(q * x)) / pixel
    assert found.mean() == pytest.approx(0.0, abs=1e-6)
    assert np.ptp(found, axis=1).max() < 1e-3 * abs(expected).max()
    # the flux is linear over a step, in which the phase of the wave changes by .2
    assert found[:, 0] == pytest.approx(expected, abs=0.01 * abs(expected).max())


def test_a_wave_that_rides_with_the_body_warms_it_as_at_rest():
    cell, steps, diffusivity, speed = Cell(32, 1e-3), 64, 7.6e-6, 0.5
    way, q, pixel = even_way(steps, cell), 2 * np.pi / 1e-3, 1e-3 / 32
    wave = 1 + 0.3 * np.cos(q * np.arange(32) * pixel)[:, None] * np.ones(32)
    planes = [np.roll(wave, -n, axis=0) for n in range(1, steps + 1)]
    moving, resting = Body(12.0, diffusivity), Body(INSULATING, 1e-6)
    found = at_the_end(planes, way, cell, speed=speed, moving=moving, resting=resting)
    time = steps * pixel / speed
    grown = quad(
        lambda u: 2 * np.sqrt(diffusivity / np.pi) * np.exp(-diffusivity * q**2 * u**2),
        0,
        np.sqrt(time),
    )[0]
    assert found[:, 0] == pytest.approx(
        (planes[-1][:, 0] - 1) * grown / pixel, abs=0.003 * grown / pixel
    )


def test_bodies_that_are_exchanged_have_one_temperature_in_the_contact():
    # T₁ = T₂ there: seen from the other body, which slides the other way, T above the mean differs by a constant
    cell = Cell(64, 1e-3)
    field = clipped.clipped_field(SelfAffine(level=1e-24), **STEEL)
    rng = np.random.default_rng(3)
    q = np.hypot(np.fft.fftfreq(64)[:, None], np.fft.rfftfreq(64))
    smooth = np.exp(-((q / 0.06) ** 2))
    faces = []
    for _ in range(2):
        z = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((64, 64))) * smooth)
        faces.append(((z - z.mean()) / z.std())[None])
    way = oblique_way(40e-3 / 64, cell)
    contacts = list(pressures(field, *faces, 0.3, way))
    moved = [
        np.roll(plane, tuple(offset), axis=(1, 2))
        for plane, offset in zip(contacts, way.offset, strict=True)
    ]
    one, other = Body(30.0, 7.6e-6), Body(80.0, 2e-6)
    there = at_the_end([p[0] for p in contacts], way, cell, speed=2.0, moving=one, resting=other)
    back = Way(-way.offset, way.length)
    here = at_the_end([p[0] for p in moved], back, cell, speed=2.0, moving=other, resting=one)
    here = (
        np.roll(here, tuple(-way.offset[-1]), axis=(0, 1)) * 30.0 / 80.0
    )  # in the unit of the other conductivity
    touching = contacts[-1][0] > 0.0
    assert 0.03 < touching.mean() < 0.5
    apart = (here - there)[touching]
    assert apart.std() < 0.03 * there[touching].std()
    assert (here - there)[~touching].std() > 0.1 * there[touching].std()  # it is not so outside


def test_each_position_carries_the_load_and_has_the_areas_of_the_field():
    cell = Cell(96, 1e-3)
    field = clipped.clipped_field(SelfAffine(level=3e-25), **STEEL)
    rng = np.random.default_rng(5)
    faces = [rng.standard_normal((2, 96, 96)) for _ in range(2)]
    way = oblique_way(10e-3 / 96, cell)
    share = float(ndtr(-field.levels[0]))
    for plane in pressures(field, *faces, 0.4, way):
        assert plane.mean(axis=(1, 2)) == pytest.approx([1.0, 1.0], rel=1e-5)
        assert (plane > 0.0).mean(axis=(1, 2)) == pytest.approx([share, share], rel=0.01)
    still = list(pressures(field, *faces, 0.0, way))
    assert all(plane is still[0] for plane in still)
    riding = list(pressures(field, *faces, 1.0, way))
    for plane, offset in zip(riding, way.offset, strict=True):
        assert (np.roll(plane, tuple(offset - way.offset[0]), axis=(1, 2)) == riding[0]).all()


@pytest.mark.parametrize("distance", [1e-6, 3e-4, 1e-3, 2.345e-2])
def test_a_way_ends_at_its_distance_with_steps_of_a_pixel(distance):
    cell = Cell(100, 1e-3)
    way = oblique_way(distance, cell)
    assert way.length.sum() == pytest.approx(distance, rel=1e-6)
    along = 1e-5 * np.hypot(*way.offset[-1])
    assert along == pytest.approx(distance, abs=1e-5)
    assert way.length.size >= 16
    assert way.length[-min(LAST, 16) :] == pytest.approx(way.length[-1], rel=1e-9)
    passed = np.cumsum(way.length[::-1])[::-1]  # from the start of a step to the end of the way
    assert (way.length <= np.maximum(passed / LAST, way.length[-1] * (1 + 1e-9))).all()
    # slightly oblique
    assert way.offset[-1, 1] == pytest.approx(
        ((np.sqrt(5) - 1) / 2) ** 4 * way.offset[-1, 0], abs=0.5
    )


def test_a_smooth_body_that_takes_all_heat_feels_the_frozen_contact():
    # one face is smooth, the resting body insulating: as `temperature_distribution`, along another direction
    some = STEEL | BODY | {"fields": 4}
    spectrum = SelfAffine(level=1e-23, q_min=2e4, q_max=1.6e5)
    frozen = clipped.temperature_distribution(
        2.0, spectrum, **some, friction_coefficient=0.1, points=256
    )
    slid = clipped.sliding_temperature_distribution(
        2.0,
        spectrum,
        **some,
        resting_conductivity=INSULATING,
        resting_diffusivity=1e-6,
        moving_roughness=0.0,
        slid_distance=2e-3,
        flash_temperature=1.0,
    )
    known, own = frozen.quantiles(SHARES[:6]), slid.quantiles(SHARES[:6])
    error = np.hypot(known.standard_error / frozen.flash_temperature, own.standard_error)
    assert (np.abs(own.value - known.value / frozen.flash_temperature) < 4 * error + 0.03).all()
    assert slid.contact_fraction == frozen.contact_fraction
    assert slid.ratio @ slid.pressure / slid.pressure.sum() == pytest.approx([1.0], rel=1e-9)


def test_in_full_contact_the_temperature_is_normal():
    spectrum = SelfAffine(level=1e-29, q_max=4e5)
    solid = {"effective_modulus": MODULUS, "nominal_pressure": 0.5e11, "penetration_hardness": 1e11}
    speed = 0.02
    found = clipped.sliding_temperature_distribution(
        speed,
        spectrum,
        **solid,
        **BODY,
        resting_conductivity=INSULATING,
        resting_diffusivity=1e-6,
        moving_roughness=0.0,
        slid_distance=5e-3,
        flash_temperature=2.0,
        fields=2,
    )
    assert found.contact_fraction == pytest.approx(1.0, abs=1e-9)
    stress = plasticity.stress_spectrum(spectrum, **solid)
    law = {
        "stress_spectrum": stress,
        "nominal_pressure": 0.5e11,
        "friction_coefficient": 0.1,
        **BODY,
    }
    over = float(flash.rms_temperature(speed, **law) / flash.flash_temperature(speed, **law))
    spread = found.deviation(by="area")
    assert spread.value / 2.0 == pytest.approx(over, rel=0.08)
    shares = np.array([0.05, 0.25, 0.5, 0.75, 0.95])
    even = found.quantiles(shares, by="area")
    expected = spread.value * ndtri(shares)
    assert (
        np.abs(even.value[:, 0] - expected) < 4 * even.standard_error[:, 0] + 0.01 * spread.value
    ).all()


def test_steel_has_the_quantiles_of_slides():
    # experiments/reactions.py --slide: boundary-element contacts up to 1.016e5 1/m; slow and fast
    slid = np.array(
        [
            (0.316, 0.677, 0.972, 1.295, 1.598, 2.135, 2.444),
            (0.319, 0.689, 0.984, 1.290, 1.568, 2.049, 2.367),
        ]
    )
    found = clipped.sliding_temperature_distribution(
        [1.0, 35.0],
        Steel(),
        **STEEL,
        **BODY,
        slid_distance=2e-3,
        flash_temperature=[26.5, 284.0],
        fields=3,
    )
    over = found.quantiles(SHARES)
    ratio = (over.value / found.flash_temperature).T
    assert np.abs(ratio - slid)[:, :5].max() < 0.05
    assert np.abs(ratio - slid)[:, 5:].max() < 0.15


def test_hot_places_of_waves_that_are_not_drawn_are_those_of_frozen_contact():
    small = {
        **STEEL,
        **BODY,
        "fields": 2,
        "points": 48,
        "slid_distance": 3e-4,
        "flash_temperature": 1.0,
    }
    # two longest waves of 48 points: the shortest of six is 4 q_min
    drawn = clipped.sliding_temperature_distribution(
        3.0, SelfAffine(level=1e-23, q_max=2e5), **small
    )
    whole = clipped.sliding_temperature_distribution(
        3.0, SelfAffine(level=1e-23, q_max=2e6), **small
    )
    above = []
    for end in (2e5, 2e6):
        heat = BODY | {"friction_coefficient": 1.0}
        frozen = clipped.temperature_distribution(
            3.0, SelfAffine(level=1e-23, q_max=end), **STEEL, **heat
        )
        above.append(frozen.quantiles(0.99).value[0, 0] / frozen.flash_temperature[0] - 1)
    growth = above[1] / above[0]
    assert abs(growth - 1) > 0.02
    assert whole.ratio - 1 == pytest.approx(growth * (drawn.ratio - 1), rel=1e-9, abs=1e-12)


def test_speeds_keep_their_order_and_seeds_their_fields():
    small = {
        "spectrum": SelfAffine(level=1e-24, q_max=2e5),
        **STEEL,
        **BODY,
        "fields": 2,
        "points": 48,
    }
    small |= {"slid_distance": 3e-4, "flash_temperature": 5.0}
    one = clipped.sliding_temperature_distribution([3.0, -0.1], **small)
    again = clipped.sliding_temperature_distribution([0.1, 3.0], **small)
    other = clipped.sliding_temperature_distribution(3.0, **small, seed=1)
    assert one.ratio.tolist() == again.ratio[::-1].tolist()
    assert other.pressure.size != one.pressure.size or (other.ratio != one.ratio[:1]).any()
    assert one.flash_temperature.tolist() == [5.0, 5.0]
    assert (np.diff(one.field) >= 0).all()
    twins = clipped.sliding_temperature_distribution(
        3.0, **small, resting_conductivity=30.0, resting_diffusivity=7.6e-6
    )
    assert twins.ratio[0] == pytest.approx(one.ratio[0], rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"speed": 0.0}, "speed = 0 m/s must be positive"),
        ({"flash_temperature": -1.0}, "flash_temperature = -1 K"),
        ({"slid_distance": 0.0}, "slid_distance = 0 m"),
        ({"moving_roughness": 1.1}, "moving_roughness = 1.1 must lie from 0 to 1"),
        ({"resting_conductivity": 0.0}, "resting_conductivity = 0"),
        ({"fields": 1}, "fields = 1 must be a whole number of 2 or more"),
        ({"points": 40}, "points = 40"),
        ({"seed": -1}, "seed = -1"),
        ({"penetration_hardness": 1e6}, "exceeds the penetration_hardness"),
    ],
)
def test_a_slide_that_cannot_be_is_refused(changes, message):
    given = {
        "speed": 1.0,
        "spectrum": SelfAffine(),
        "slid_distance": 1e-3,
        "flash_temperature": 1.0,
    }
    with pytest.raises(ValueError, match=message):
        clipped.sliding_temperature_distribution(**given | STEEL | BODY | changes)


def test_temperatures_that_stay_unequal_are_an_error(monkeypatch):
    cell = Cell(64, 1e-3)
    pair = Pair(
        cell, even_way(2, cell), 1, speed=1.0, moving=Body(30.0, 7.6e-6), resting=Body(3.0, 1e-6)
    )
    pressure = np.zeros((1, 64, 64), np.float32)
    pressure[0, 20:30, 20:30] = 40.0
    monkeypatch.setattr("theory.clipped.two_faces._ROUNDS", 1)
    monkeypatch.setattr("theory.clipped.two_faces._EQUAL", 1e-6)
    with pytest.raises(
        ArithmeticError,
        match=r"^temperatures of the two bodies: after 1 rounds they differ by .*, 1e-06",
    ):
        pair.advance(pressure)
