"""Where the waves of an uneven contact put their pressure: sums of vectors, and the answer of the half-space."""

import numpy as np
import pytest
from yielding_cases import HARDNESS, MODULUS, SelfAffine

from theory.interface import between_shells, diffuse
from theory.scattering import ANSWER, BIN, beside, scatter, stiffness_variance, sums_of_waves


def test_a_wave_beside_another_has_the_sum_of_their_squares():
    count, bins = 60, np.arange(-60, 60)
    table = sums_of_waves(count)
    assert table.sum(axis=1) == pytest.approx(1.0, abs=1e-12)
    squares = table @ np.exp(2 * BIN * bins)
    near = np.abs(bins) < 20
    assert squares[near] == pytest.approx(1 + np.exp(2 * BIN * bins[near]), rel=1e-2)


@pytest.mark.parametrize(("wave", "other"), [(0, 0), (1, 1), (2, 1)])
def test_a_shell_modulated_by_one_other_lies_at_their_vector_sum_wherever_the_bins_fall(
    wave, other
):
    # half of the pressure of shell 2 is that of a wave of one other shell added to it; its own waves are those before
    x, own, share = np.array([0.0112, 0.4463, 0.8863]), np.array([1.0, 1.0, 0.5]), np.zeros((3, 3))
    share[2, wave] = 0.5
    grid = np.arange(-1.0, 3.5, BIN)
    parts = beside(x, own, share, grid)
    assert parts[:2] == pytest.approx(0.0, abs=1e-15)
    expected = 0.5 * (np.exp(2 * x[2]) + np.exp(2 * x[other]))
    assert parts[2] @ np.exp(2 * grid) == pytest.approx(
        expected, rel=1.5e-2
    )  # bins: (2 BIN)²/8 at most


CONTACTS = pytest.mark.parametrize(
    ("spectrum", "pressure", "hardness"),
    [
        (SelfAffine(q_max=1e6), 0.1 * HARDNESS, HARDNESS),
        (SelfAffine(), 0.02 * HARDNESS, HARDNESS),
        pytest.param(SelfAffine(level=2e-25), 0.02 * HARDNESS, HARDNESS, marks=pytest.mark.slow),
        (SelfAffine(level=1e-27, q_max=2e6), 3e8, 1e12),
    ],
)


def unevenness(diffusion):
    """ln q of the shells, mean of kappa, and the variance of kappa that each shell makes, (shell, k)."""
    x = np.log(diffusion.wavenumber)
    x = (x[1:] + x[:-1]) / 2
    mean = np.sum(diffusion.probability * diffusion.stiffness, axis=1)
    made = np.diff(stiffness_variance(diffusion), axis=1)
    return x, (mean[1:] + mean[:-1]) / 2, made


def test_the_unevenness_is_carried_back_by_an_implicit_step_from_shell_to_shell():
    diffusion = diffuse(SelfAffine(q_max=1e6), MODULUS, 0.1 * HARDNESS, HARDNESS)
    gap, growth = np.diff(diffusion.pressure), diffusion.growth
    lower, higher = gap[:-1], gap[1:]

    def back(values, spread):
        rates = np.zeros((growth.shape[1],) * 2)
        inner = np.arange(1, growth.shape[1] - 1)
        rates[inner, inner + 1] = 1 / (higher * (lower + higher))
        rates[inner, inner - 1] = 1 / (lower * (lower + higher))
        rates -= np.diag(rates.sum(axis=1))
        return np.linalg.solve(np.eye(rates.shape[0]) - spread[:, None] * rates, values)

    found = stiffness_variance(diffusion)
    for shell in (1, 17, growth.shape[0] - 1):
        stiffness, there = (
            (each[shell] + each[shell + 1]) / 2
            for each in (diffusion.stiffness, diffusion.probability)
        )
        mean = there @ stiffness
        carried, expected = back(stiffness, growth[shell] / 2), []
        for before in range(shell, -1, -1):
            expected.append(diffusion.probability[before] @ carried**2 - mean**2)
            carried = back(carried, growth[before - 1])
        expected = np.maximum.accumulate(np.maximum(expected[::-1], 0.0))
        whole = there @ stiffness**2 - mean**2
        np.testing.assert_allclose(found[shell, : shell + 1], expected, rtol=0, atol=1e-8 * whole)
        np.testing.assert_allclose(found[shell, shell + 1 :], whole, rtol=1e-9)


@CONTACTS
def test_waves_that_are_modulated_in_turn_add_up_as_vectors(spectrum, pressure, hardness):
    # walks by chance: a wave k for the unevenness of kappa, another one for that of its own, until there is none
    x, mean, made = unevenness(diffuse(spectrum, MODULUS, pressure, hardness))
    whole = mean**2 + made.sum(axis=1)
    own, share = mean**2 / whole, made / whole[:, None]
    grid = np.arange(x[0] - 1.0, x[-1] + 2.5, BIN)
    parts, rng = beside(x, own, share, grid), np.random.default_rng(1)
    assert parts.sum(axis=1) == pytest.approx(1 - own, abs=1e-12)
    for shell in (int(np.argmax(1 - own > 0.1 * (1 - own[-1]))), x.size - 1):
        squares, count = [], 2000
        for _ in range(count):
            here, total, steps = shell, 0.0, 0
            while True:
                total += np.exp(x[here] + 2j * np.pi * rng.uniform())
                if rng.uniform() < own[here]:
                    break
                k = int(
                    rng.choice(here + 1, p=share[here, : here + 1] / share[here, : here + 1].sum())
                )
                here, steps = max(k - 1, 0) if k == here else k, steps + 1
            squares.append(abs(total) ** 2 if steps else 0.0)
        expected, doubt = np.mean(squares), np.std(squares) / np.sqrt(count)
        assert parts[shell] @ np.exp(2 * grid) == pytest.approx(
            expected, abs=4 * doubt + 0.03 * expected
        )


@CONTACTS
def test_the_half_space_answers_beside_a_wave_as_two_springs_in_series_want(
    spectrum, pressure, hardness
):
    diffusion = diffuse(spectrum, MODULUS, pressure, hardness)
    x, mean, made = unevenness(diffusion)
    whole = mean**2 + made.sum(axis=1)
    grid = np.arange(x[0] - 1.0, x[-1] + 2.5, BIN)
    parts = beside(x, mean**2 / whole, made / whole[:, None], grid)
    total = diffusion.probability @ (diffusion.pressure - pressure) ** 2
    square = np.sum(diffusion.probability * diffusion.stiffness**2, axis=1)
    made_of, power, lowest = scatter(diffusion, MODULUS), 0.0, 0.0
    q = diffusion.wavenumber
    for m in range(x.size):
        compliance = max(
            2 * mean[m] / (square[m] + square[m + 1]) - 2 / (MODULUS * np.exp(x[m])), 0.0
        )
        near, far = (
            compliance + 2 / (MODULUS * np.exp(x[m])),
            compliance + 2 / (MODULUS * np.exp(grid)),
        )
        answer = (near / far) ** ANSWER
        change = 2 * parts[m] @ (answer - 1) * whole[m] / mean[m] ** 2
        full = (MODULUS / 2) ** 2 * float(
            between_shells(q[m : m + 2] ** 2, diffusion.variance[m : m + 2])[0]
        )
        factor = 1 + change if change > 0 else 1 / (1 - change)
        growth = total[m + 1] - total[m]
        coherent = growth / full * mean[m] ** 2 / whole[m] * factor
        assert np.exp(made_of.coherent.value[m + 1]) == pytest.approx(coherent, rel=1e-9)
        power += growth * parts[m] @ answer**2
        lowest += growth * parts[m, 0] * answer[0] ** 2
    other = np.exp(made_of.sidebands.place)
    area = 2 * np.pi * other**2 * BIN
    area[0] = np.pi * other[0] ** 2
    assert np.exp(made_of.sidebands.value) @ area == pytest.approx(power, rel=1e-3)
    assert np.exp(made_of.sidebands.value[0]) * area[0] == pytest.approx(
        lowest, rel=1e-9
    )  # a whole disc
    ends = made_of.coherent.place[[0, -1]], made_of.coherent.value[-2:]
    assert ends[0] == pytest.approx(np.log(q[[0, -1]]), rel=1e-12)
    assert ends[1][0] == ends[1][1]
