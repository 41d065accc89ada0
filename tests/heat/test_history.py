"""A half-space that remembers its heat: exact kernels, the mean over all steps, and second order in the step."""

from math import pi, sqrt

import numpy as np
import pytest
from scipy import integrate, special

from roughsim import Grid
from roughsim.heat.history import KERNEL_ERROR, History, exponentials, latest_step, mean_weights

STEEL = 30.0, 7.6e-6
GRID = Grid((8, 8), (1e-3, 1e-3))


def last_temperature(
    flux_of_time, duration, steps, conductivity=STEEL[0], diffusivity=STEEL[1], mode=(0, 0)
):
    """The temperature of one mode at the end, its flux given as a function of time."""
    step = duration / steps

    def spectrum(n):
        values = np.zeros(GRID.half_shape, complex)
        values[mode] = flux_of_time(n * step)
        return values

    history = History(GRID, conductivity, diffusivity, step, steps, spectrum(0))
    for n in range(1, steps + 1):
        temperature = history.known() + history.response * spectrum(n)
        history.advance(spectrum(n))
    return temperature[mode]


@pytest.mark.parametrize("steps", [1, 2, 3, 17, 512, 5000])
def test_the_sum_of_exponentials_is_the_inverse_root(steps):
    rates, weights = exponentials(steps)
    times = np.geomspace(1, max(steps, 2), 7919)
    assert (weights > 0).all()
    assert (rates > 0).all()
    assert rates.size < 25
    assert (
        np.abs(np.sqrt(times) * (np.exp(-np.outer(times, rates)) @ weights) - 1).max()
        < 1.1 * KERNEL_ERROR
    )


@pytest.mark.parametrize("decay", [0.0, 1e-9, 1e-3, 0.5, 3.0, 39.0, 500.0])
def test_the_latest_step_is_integrated_exactly(decay):
    late, early = (float(part[0]) for part in latest_step(np.array([decay])))
    # u = x²: the root is gone
    expected = [
        integrate.quad(
            lambda x, w=w: 2 * w(x * x) * np.exp(-decay * x * x),
            0,
            1,
            points=[min(1, 1 / sqrt(decay + 1))],
        )[0]
        for w in (lambda u: 1 - u, lambda u: u)
    ]
    assert late == pytest.approx(expected[0], rel=1e-9)
    assert early == pytest.approx(expected[1], rel=1e-9)


@pytest.mark.parametrize("steps", [1, 2, 5, 99, 100, 101, 102, 700])
def test_a_flux_linear_in_time_warms_the_mean_exactly(steps):
    # ∫₀^t (a + bτ) (t − τ)^(−1/2) dτ = 2a√t + 4/3 b t^(3/2)
    duration = 1e-3
    expected = (
        sqrt(STEEL[1] / pi) / STEEL[0] * (2 * 5e6 * sqrt(duration) + 4 / 3 * 3e9 * duration**1.5)
    )
    assert last_temperature(lambda t: 5e6 + 3e9 * t, duration, steps) == pytest.approx(
        expected, rel=1e-12
    )


def test_the_weights_of_the_mean_hold_one_by_one():
    inner, first = mean_weights(300)
    for m in (0, 1, 2, 50, 98, 99, 100, 101, 102, 250, 300):
        hat = integrate.quad(
            lambda x, m=m: 2 * max(0.0, 1 - abs(x * x - m)), sqrt(max(m - 1, 0)), sqrt(m)
        )[0]
        up = integrate.quad(lambda x, m=m: 2 * max(0.0, 1 - abs(x * x - m)), sqrt(m), sqrt(m + 1))[
            0
        ]
        assert inner[m] == pytest.approx(hat + up, rel=1e-9)
        assert first[m] == pytest.approx(hat, rel=1e-9)


def test_a_moving_wave_warms_the_body_as_the_error_function_says_at_second_order():
    # flux e^(iωt) at wavenumber q: κT = erf(λ√(Dt))/λ e^(iωt), λ² = q² + iω/D
    q, omega, duration = 2 * pi / 1e-3, 2 * pi * 1e3, 1.3e-3
    wave = np.sqrt(q**2 + 1j * omega / STEEL[1])
    expected = (
        special.erf(wave * np.sqrt(STEEL[1] * duration))
        / wave
        / STEEL[0]
        * np.exp(1j * omega * duration)
    )
    errors = [
        abs(
            last_temperature(lambda t: np.exp(1j * omega * t), duration, steps, mode=(1, 0))
            / expected
            - 1
        )
        for steps in (50, 100, 200)
    ]
    assert errors[0] < 5e-3
    assert errors[0] / errors[1] == pytest.approx(4, abs=0.4)
    assert errors[1] / errors[2] == pytest.approx(4, abs=0.4)


def test_heat_that_stopped_fades_as_the_kernel_says():
    # a pulse, linear up and down over two steps at the beginning, long ago: q̇Δt √(D/(πτ)) e^(−Dq²τ)/κ
    q, duration, steps = 2 * pi / 1e-3, 2e-2, 4000
    step = duration / steps
    late = last_temperature(
        lambda t: 1.0 if abs(t - step) < step / 2 else 0.0, duration, steps, mode=(0, 1)
    )
    since = duration - step
    expected = step * sqrt(STEEL[1] / (pi * since)) * np.exp(-STEEL[1] * q**2 * since) / STEEL[0]
    assert late == pytest.approx(expected, rel=2 * KERNEL_ERROR)


def test_a_short_wave_keeps_what_a_step_leaves_of_it():
    # D q² Δt = 2: a constant flux gives erf(√(D q² t))/q, of which a seventh is of the steps before the latest
    q, steps = 2 * pi / 1e-3, 6
    step = 2.0 / (STEEL[1] * q**2)
    expected = special.erf(q * sqrt(STEEL[1] * step * steps)) / q / STEEL[0]
    assert last_temperature(lambda _: 1.0, steps * step, steps, mode=(1, 0)) == pytest.approx(
        expected, rel=KERNEL_ERROR
    )


@pytest.mark.parametrize("decay", [1e-4, 0.1, 1.0, 10.0, 100.0])
def test_the_weights_of_the_steps_have_a_positive_real_part_at_every_frequency(decay):
    # else a share that changes from step to step could grow without bound
    steps, mode = 400, (1, 0)
    step = decay / (STEEL[1] * (2 * pi / 1e-3) ** 2)
    history, weights = History(GRID, *STEEL, step, steps, np.zeros(GRID.half_shape, complex)), []
    for n in range(steps):
        pulse = np.full(GRID.half_shape, n == 0, complex)
        weights.append((history.known() + history.response * pulse)[mode].real)
        history.advance(pulse)
    angles = np.linspace(0, pi, 401)[1:]
    real = np.cos(np.outer(angles, np.arange(steps))) @ weights
    # what is cut off is under half of the last weight over sin(angle/2), the alternating end of the sum
    cut = weights[-1] / np.sin(angles / 2)
    assert ((real + cut) / weights[0]).min() > 0.47
    assert (real / weights[0])[-1] > 0.47 - weights[-1] / weights[0]
