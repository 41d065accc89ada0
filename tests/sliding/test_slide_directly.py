"""The slide against a direct sum over all its past: by quadrature and dense systems of equations."""

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from scipy import special

from roughsim import Body, Grid, Skin, Solid
from roughsim.sliding.correlation import StressCorrelation
from roughsim.sliding.path import oblique_path
from roughsim.sliding.stepping import NUMBERS, Motion, contacts, walk

COUNT, CELL, SPEED = 12, 1e-3, 3.0
PAIRS = {  # resting, moving
    "bare": (Body(30.0, 7.6e-6), Body(5.0, 2e-6, SPEED)),
    "layered": (
        Body(30.0, 7.6e-6, skin=Skin(1.2e-5, 4.0, 7.6e-6)),
        Body(5.0, 2e-6, SPEED, heat_depth=5e-6),
    ),
}
HEATING = 0.3 * SPEED


Q = 2 * pi * np.fft.fftfreq(COUNT, CELL / COUNT)
SQUARE = Q[:, None] ** 2 + Q**2
LOW = (SQUARE > 0) & (np.sqrt(SQUARE) < 2 * pi / CELL * 4)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(120)
ACROSS = ((np.sqrt(5) - 1) / 2) ** 4


def layered_over_bare(body, reach):
    """Kernel of a body with a skin of its own diffusivity, or heated in depth, over that of a bare one; √(Dτ)."""
    if body.skin:
        ratio = body.skin[1] / body.conductivity
        echo = (ratio - 1) / (
            ratio + 1
        )  # of the images of the surface in the two faces of the skin
        images = sum(echo**n * np.exp(-((n * body.skin[0] / reach) ** 2)) for n in range(1, 60))
        return (1 + 2 * images) / ratio
    if body.heat_depth:
        return np.sqrt(np.pi) * reach / body.heat_depth * special.erfcx(reach / body.heat_depth)
    return np.ones_like(reach)


def positions(bodies):
    rng = np.random.default_rng(4)
    first, second = (
        np.real(np.fft.ifft2(np.fft.fft2(rng.standard_normal((COUNT, COUNT))) * LOW))
        for _ in range(2)
    )
    grid = Grid((COUNT, COUNT), (CELL, CELL))
    path = oblique_path(grid, 1.7 * CELL)
    contacts_along = contacts(
        1e-5 * first, 1e-5 * second, grid, Solid(1e9, 4e7), 1e7, path, tolerance=3e-3
    )
    return list(walk(contacts_along, grid, path, [Motion(SPEED, 0.3, bodies[1], bodies[0])]))


def directly(steps, bodies):
    """Numbers of each step, from matrices that take the flux of any earlier step to the temperature of a later one."""
    duration = (steps[1].slid_distance - steps[0].slid_distance) / SPEED
    distinct, place = np.unique(SQUARE.round(3), return_inverse=True)

    def weights(body, lag, ends):
        """Temperature of each mode by the part between `ends` of the hat `lag` steps ago; u = w²: no root."""
        values = 0.0
        for a, b in pairwise(np.sqrt(ends)):
            w = a + (b - a) * (1 + NODES) / 2
            kernel = layered_over_bare(body, np.sqrt(body.diffusivity * duration) * w)
            decay = np.exp(-body.diffusivity * duration * distinct[:, None] * w**2)
            values = values + decay @ ((b - a) * WEIGHTS * (1 - abs(w**2 - lag)) * kernel)
        return (
            np.sqrt(body.diffusivity * duration / pi)
            / body.conductivity
            * values[place].reshape(COUNT, COUNT)
        )

    def spectrum(body, lag):
        return weights(body, lag, [end for end in (lag - 1, lag, lag + 1) if end >= 0])

    def before(body, lag):
        return weights(body, lag, (lag, lag + 1))

    spectra = [[spectrum(body, lag) for lag in range(len(steps))] for body in bodies]
    # a uniform flux of the first step warms both alike
    warming = [
        spectra[b][0][0, 0] + (spectra[b][1] - before(body, 1))[0, 0]
        for b, body in enumerate(bodies)
    ]
    past = [[], []]
    rows = []
    for n, step in enumerate(steps):
        heat = HEATING * step.contact.pressure
        if n == 0:
            for body in range(2):
                past[body].append(heat * warming[1 - body] / sum(warming))
            continue
        offset = np.array([n, round(n * ACROSS)])
        shift = (0, 0), tuple(offset)

        def warmed(body, flux, lag, shift=shift, first=n):
            """Temperature now, in the frame of the resting body, by a flux in the frame of this one."""
            factor = spectra[body][lag]
            # the oldest flux, at time 0, has only the half of its hat that lies after it
            if lag == first:
                factor = factor - before(bodies[body], lag)
            field = np.fft.ifft2(np.fft.fft2(flux) * factor).real
            return np.roll(field, [-s for s in shift[body]], axis=(0, 1))

        known = [
            sum(warmed(body, flux, n - m) for m, flux in enumerate(past[body])) for body in range(2)
        ]
        touching = np.flatnonzero(step.contact.pressure > 0)
        unit = np.zeros((COUNT, COUNT))
        unit[0, 0] = 1.0
        kernels = [np.fft.ifft2(np.fft.fft2(unit) * spectra[body][0]).real for body in range(2)]
        i, j = np.unravel_index(touching, (COUNT, COUNT))
        matrix = sum(
            kernel[(i[:, None] - i) % COUNT, (j[:, None] - j) % COUNT] for kernel in kernels
        )
        hot = known[0] + np.fft.ifft2(np.fft.fft2(heat) * spectra[0][0]).real
        entering = np.zeros(COUNT * COUNT)
        entering[touching] = np.linalg.solve(matrix, (hot - known[1]).ravel()[touching])
        entering = entering.reshape(COUNT, COUNT)
        parts = heat - entering, entering
        fields = [
            known[b] + np.fft.ifft2(np.fft.fft2(parts[b]) * spectra[b][0]).real for b in range(2)
        ]
        past[0].append(parts[0])
        past[1].append(np.roll(entering, offset, axis=(0, 1)))
        weight = heat / heat.sum()
        totals = [float((field * weight).sum()) for field in fields]
        backgrounds = [float(field.mean()) for field in fields]
        rows.append(
            (
                totals[1] - backgrounds[1],
                totals[0] - backgrounds[0],
                entering.sum() / heat.sum(),
                backgrounds[1],
                backgrounds[0],
                totals[1],
            )
        )
    return np.array(rows)


@pytest.mark.parametrize("bodies", PAIRS.values(), ids=PAIRS)
def test_the_slide_is_the_direct_sum_over_all_its_past(bodies):
    steps = positions(bodies)
    assert len(steps) > 18
    assert 0.2 < steps[-1].contact.contact_fraction < 0.8
    expected = directly(steps, bodies)
    slid = np.array([step.numbers[:, 0] for step in steps[1:]])
    for k, name in enumerate(NUMBERS[:6]):
        scale = np.abs(expected[:, k]).max()
        assert np.abs(slid[:, k] - expected[:, k]).max() < 2e-4 * scale, name


def test_the_stress_correlation_is_that_of_all_pairs_with_the_anchors():
    grid = Grid((8, 8), (1.0, 1.0))
    fields = np.random.default_rng(3).standard_normal((21, 8, 8))
    fields += 5.0 - fields.mean(axis=(1, 2), keepdims=True)  # all carry one load
    correlation = StressCorrelation(grid, len(fields))
    for field in fields:
        correlation.add(np.fft.rfft2(field) / 64)
    # anchors 0, 4, 8 … are left of those that were taken on the way; each stands with all that came while it was there
    at_zero = np.mean([fields[n].var() for n in (0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20)])
    got = correlation.mean() * correlation.sums[0] / correlation.counts[0]
    assert correlation.sums[0] / correlation.counts[0] == pytest.approx(at_zero)
    assert got[-1] == pytest.approx(np.mean((fields[0] - 5.0) * (fields[20] - 5.0)))
