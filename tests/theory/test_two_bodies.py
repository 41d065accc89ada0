"""Two rough bodies that slide over one another: exact cases, symmetries, and the definition by drawn heights."""

import numpy as np
import pytest
from scipy.special import erf, wofz
from yielding_cases import HARDNESS, MODULUS, SelfAffine

from theory import background, clipped, flash, partition, persson, plasticity, two_bodies

SPEEDS = np.array([0.1, 3.0, 60.0])
SOLID = {"effective_modulus": MODULUS, "nominal_pressure": 0.1 * HARDNESS, "penetration_hardness": HARDNESS}
STEEL = {"conductivity": 30.0, "diffusivity": 7.6e-6}
GLASS = {"resting_conductivity": 1.0, "resting_diffusivity": 5e-7}
BODIES = {"moving": (30.0, 7.6e-6), "resting": (1.0, 5e-7)}  # κ and D
SPECTRUM = SelfAffine(level=1e-26, q_max=2e6)
FRICTION = 0.2


def sliding(speed=SPEEDS, spectrum=SPECTRUM, slid_distance=4e-3, **changes):
    given = {**SOLID, **STEEL, "friction_coefficient": FRICTION, "slid_distance": slid_distance, **changes}
    return two_bodies.sliding_temperatures(speed, spectrum, **given)


def law():
    stress = plasticity.stress_spectrum(SPECTRUM, **SOLID)
    density = persson.stress_density(stress_spectrum=stress)
    return stress, density.wavenumber(), density.weighted()


def test_twins_share_the_heat_evenly():
    slid = sliding()
    assert slid.moving_share == pytest.approx(0.5, abs=1e-12)
    assert slid.flash_temperature == pytest.approx(slid.resting_flash_temperature, rel=1e-12)
    assert slid.background == pytest.approx(slid.resting_background, rel=1e-12)


@pytest.mark.parametrize("part", [0.0, 0.3, 0.5])
def test_both_bodies_have_one_contact_temperature_and_all_the_heat(part):
    slid = sliding(moving_roughness=part, **GLASS)
    total = slid.resting_flash_temperature + slid.resting_background
    assert slid.contact_temperature == pytest.approx(total, rel=1e-11)
    assert slid.contact_temperature == pytest.approx(slid.flash_temperature + slid.background, rel=1e-12)
    for n, speed in enumerate(SPEEDS):
        flux = FRICTION * speed * SOLID["nominal_pressure"]
        moving = background.temperature(4e-3 / speed, heat_flux=flux * slid.moving_share[n], **STEEL)
        glass = {"conductivity": 1.0, "diffusivity": 5e-7}
        resting = background.temperature(4e-3 / speed, heat_flux=flux * (1 - slid.moving_share[n]), **glass)
        assert (slid.background[n], slid.resting_background[n]) == pytest.approx((moving, resting), rel=1e-12)


@pytest.mark.parametrize("part", [0.0, 0.2, 0.5])
def test_the_bodies_exchanged_with_their_roughness_exchange_their_temperatures(part):
    slid = sliding(moving_roughness=part, **GLASS)
    other = sliding(
        moving_roughness=1 - part,
        conductivity=1.0,
        diffusivity=5e-7,
        resting_conductivity=30.0,
        resting_diffusivity=7.6e-6,
    )
    assert other.resting_flash_temperature == pytest.approx(slid.flash_temperature, rel=1e-9)
    assert other.flash_temperature == pytest.approx(slid.resting_flash_temperature, rel=1e-9)
    assert other.moving_share == pytest.approx(1 - slid.moving_share, rel=1e-9)


@pytest.mark.parametrize("bodies", [{}, GLASS])
def test_a_smooth_moving_face_has_the_share_of_equal_totals(bodies):
    stress, _, _ = law()
    heat = {"stress_spectrum": stress, "nominal_pressure": SOLID["nominal_pressure"], **STEEL}
    slid = sliding(moving_roughness=0.0, **bodies)
    for n, speed in enumerate(SPEEDS):
        share = partition.moving_share(speed, rule="total", duration=4e-3 / speed, **heat, **bodies)
        flashed = share * flash.flash_temperature(speed, friction_coefficient=FRICTION, **heat)
        # that rule has the steady T_flash of the moving body: v²t/D is 50 and more
        assert slid.moving_share[n] == pytest.approx(share, rel=2e-3)
        assert slid.flash_temperature[n] == pytest.approx(flashed, rel=2e-3)


def test_a_resting_source_grows_as_the_error_function_of_each_wave():
    # all heat enters the rough resting body: the moving one is flat and does not conduct
    _, q, weight = law()
    speed, insulating = 5.0, {"conductivity": 1e-9, "resting_conductivity": 30.0, "resting_diffusivity": 7.6e-6}
    for distance in (1e-7, 1e-5, 1e-3):
        slid = sliding(speed, slid_distance=distance, moving_roughness=0.0, **insulating)
        root = np.sqrt(7.6e-6 * distance / speed)
        expected = FRICTION * speed / (30.0 * SOLID["nominal_pressure"]) * (weight * erf(q * root) / q).sum()
        assert slid.resting_flash_temperature == pytest.approx(expected, rel=1e-3)
        assert slid.moving_share < 1e-5


def test_a_moving_source_grows_as_the_complex_error_function_of_each_wave():
    # erf(λ√(Dt))/λ with λ² = q² − iqv cos φ/D, the mean over directions; erf z = 1 − e^(−z²) w(iz)
    _, q, weight = law()
    angles = (np.arange(400) + 0.5) * np.pi / 800
    speed, insulating = 5.0, {"resting_conductivity": 1e-9, "resting_diffusivity": 7.6e-6}
    for distance in (1e-6, 3e-5, 1e-3):
        slid = sliding(speed, slid_distance=distance, moving_roughness=0.0, **insulating)
        rate = np.sqrt(q[:, None] ** 2 - 1j * q[:, None] * speed * np.cos(angles) / STEEL["diffusivity"])
        z = rate * np.sqrt(STEEL["diffusivity"] * distance / speed)
        grown = ((1 - np.exp(-(z**2)) * wofz(1j * z)) / rate).real.mean(axis=1)
        expected = FRICTION * speed / (30.0 * SOLID["nominal_pressure"]) * (weight @ grown)
        assert slid.flash_temperature == pytest.approx(expected, rel=1e-3)


def test_before_any_sliding_both_bodies_have_half_of_a_resting_source():
    _, q, weight = law()
    speed = 5.0
    ratios = []
    for distance in (1e-7, 1e-8, 1e-9):
        root = np.sqrt(7.6e-6 * distance / speed)
        resting = FRICTION * speed / (30.0 * SOLID["nominal_pressure"]) * (weight * erf(q * root) / q).sum()
        ratios.append(sliding(speed, slid_distance=distance).flash_temperature / resting)
    assert ratios == pytest.approx([0.5, 0.5, 0.5], rel=1e-3)


def drawn_means(field, rng, speed, time, part, body):
    """Return (κσ₀/μv)⟨T w_i σ⟩ for the heat σw_j of one body, (3, 3), by the definition: drawn heights, ages and ways.

    The heat of the time τ ago entered at a normal distance of variance 2Dτ an axis. A pressure of other heights, far
    away, is subtracted: its products have the mean ⟨σ⟩², and most of the scatter.
    """
    draws, diffusivity = 100_000, BODIES[body][1]
    # dτ/√τ = 2√t dx with τ = tx²; short times count most, so that x = u² is drawn
    u = rng.random(draws)
    age = time * u**4
    measure = 2 * np.sqrt(time) * 2 * u * np.sqrt(diffusivity / np.pi)
    way = rng.standard_normal((2, draws)) * np.sqrt(2 * diffusivity * age)
    still, passing = field.correlation(np.hypot(*way)), field.correlation(np.hypot(way[0] - speed * age, way[1]))
    first, second = (still, passing) if body == "resting" else (passing, still)
    now, other = rng.standard_normal((2, 2, draws))
    before = np.array(
        [rho * x + np.sqrt(1 - rho**2) * y for rho, x, y in zip((first, second), now, other, strict=True)]
    )

    def weighted(heights):
        z = np.sqrt(1 - part) * heights[0] + np.sqrt(part) * heights[1]
        psi = np.sqrt(part) * heights[0] - np.sqrt(1 - part) * heights[1]
        return field.pressure(z) * np.array([np.ones(draws), psi, z * psi])

    return (measure * weighted(now)) @ (weighted(before) - weighted(other)).T / draws


@pytest.mark.parametrize(("speed", "part", "distance"), [(0.3, 0.5, 4e-3), (4.0, 0.3, 1e-3), (40.0, 0.6, 4e-3)])
def test_temperatures_are_those_of_drawn_heights_and_drawn_ways_of_the_heat(speed, part, distance):
    field = clipped.clipped_field(SPECTRUM, **SOLID)
    rng = np.random.default_rng([int(10 * speed), int(10 * part)])
    time, mean = distance / speed, SOLID["nominal_pressure"]
    batches = []
    for _ in range(12):
        flashes, totals = {}, {}
        for body, (conductivity, diffusivity) in BODIES.items():
            means = drawn_means(field, rng, speed, time, part, body) * field.variance / field.products.variance
            flashes[body] = FRICTION * speed / (conductivity * mean) * means
            grown = 2 * FRICTION * speed * mean * np.sqrt(diffusivity * time / np.pi) / conductivity
            totals[body] = flashes[body] + np.diag([grown, 0.0, 0.0])
        into_resting = np.linalg.solve(totals["moving"] + totals["resting"], totals["moving"][:, 0])
        moving = flashes["moving"][0, 0] - flashes["moving"][0] @ into_resting
        batches.append((1 - into_resting[0], moving, flashes["resting"][0] @ into_resting))
    slid = sliding(speed, slid_distance=distance, moving_roughness=part, **GLASS)
    error = np.std(batches, axis=0) / np.sqrt(len(batches) - 1)
    drawn = np.mean(batches, axis=0)
    assert (error < 0.02 * drawn).all()
    got = np.array([slid.moving_share, slid.flash_temperature, slid.resting_flash_temperature])
    assert (np.abs(got - drawn) < 4 * error + 2e-3 * got).all()


def test_elastic_bodies_need_no_hardness():
    spectrum = SelfAffine(level=3e-27, q_max=1e6, q_min=2e4)
    solid = {"nominal_pressure": 3e8, "penetration_hardness": None, "moving_roughness": 0.0}
    slid = sliding(spectrum=spectrum, slid_distance=2e-2, **solid)
    stress = persson.calibrated_spectrum(spectrum, effective_modulus=MODULUS, nominal_pressure=3e8)
    heat = {"stress_spectrum": stress, "nominal_pressure": 3e8, "friction_coefficient": FRICTION, **STEEL}
    assert slid.flash_temperature == pytest.approx(
        slid.moving_share * flash.flash_temperature(SPEEDS, **heat), rel=3e-3
    )


def test_temperatures_go_with_friction_and_do_not_know_the_direction():
    slid, doubled, back = sliding(), sliding(friction_coefficient=2 * FRICTION), sliding(-SPEEDS)
    assert doubled.contact_temperature == pytest.approx(2 * slid.contact_temperature, rel=1e-12)
    assert np.array(back) == pytest.approx(np.array(slid), rel=1e-15)


def test_shapes_follow_the_speed_and_the_distance():
    assert isinstance(sliding(1.0).flash_temperature, float)
    many = sliding(SPEEDS[:, None], slid_distance=np.array([1e-3, 4e-3]))
    assert many.moving_share.shape == (3, 2)
    assert many.flash_temperature[:, 1] == pytest.approx(sliding().flash_temperature, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"speed": 0.0}, "speed = 0 m/s"),
        ({"slid_distance": -1.0}, "slid_distance = -1 m"),
        ({"moving_roughness": 1.5}, "moving_roughness = 1.5"),
        ({"penetration_hardness": 1e6}, "exceeds the penetration_hardness"),
        ({"resting_diffusivity": 0.0}, "resting_diffusivity"),
        ({"nominal_pressure": 0.7 * HARDNESS}, "nominal_pressure/penetration_hardness"),
    ],
)
def test_a_slide_that_cannot_be_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        sliding(**changes)
