"""The flux between two bodies that closes a jump of temperature: where all of the faces touch, and where it fails."""

import re

import numpy as np
import pytest

from roughsim.errors import ConvergenceError
from roughsim.grid import Grid
from roughsim.heat.equal_temperatures import equalize

GRID = Grid((24, 32), (1e-3, 1.3e-3))
EVERYWHERE = np.ones(GRID.shape, bool)
JUMP = 40.0 * np.random.default_rng(5).standard_normal(GRID.shape)  # K
RESPONSE = 3e-7 / (1.0 + 1e-4 * GRID.wavenumbers)  # K m²/W of each mode


def flux_of_each_mode():
    """The jump of each mode over its response, W/m²."""
    return np.fft.irfft2(np.fft.rfft2(JUMP) / RESPONSE, GRID.shape)


def test_in_full_contact_the_flux_is_that_of_each_mode():
    exact = flux_of_each_mode()
    limit = 2e-5 * np.linalg.norm(JUMP)
    found = equalize(EVERYWHERE, JUMP.ravel(), RESPONSE, limit)
    assert (
        np.linalg.norm(found - exact.ravel())
        < 2e-5 * np.linalg.norm(exact) * RESPONSE.max() / RESPONSE.min()
    )


def test_the_jump_that_is_left_is_at_most_the_limit_even_if_it_is_all_of_it():
    # nothing is to be closed: the flux stays exactly zero, also if the jump is as large as the limit
    alone = np.array([40.0])
    contact = np.zeros(GRID.shape, bool)
    contact[3, 4] = True
    assert equalize(contact, alone, RESPONSE, 40.0) == 0.0
    assert equalize(contact, alone, RESPONSE, np.nextafter(40.0, 0.0)) > 0.0


def test_a_jump_that_stays_is_stated_in_kelvin_and_over_the_limit():
    contact = np.random.default_rng(6).random(GRID.shape) < 0.5
    with pytest.raises(ConvergenceError) as caught:
        equalize(contact, JUMP[contact], RESPONSE**6 * 1e30, 1e-20)
    stated = re.search(r"difference is (\S+) K after", str(caught.value))
    assert stated is not None
    left = float(stated[1])
    assert left < 0.05 * np.abs(JUMP).max()  # single precision
    assert caught.value.residual == pytest.approx(left / 1e-20, rel=5e-3)
