"""Products of a contact with itself at earlier times: exact orthant means of Gaussian heights, by sums over angles."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scipy.special import gamma, hyp1f1, ive, ndtr

from theory import clipped, memory

NORMAL = 1 / np.sqrt(2 * np.pi)  # the normal density at 0


def riesz(r):
    """N₁ and N₂ of ρ = e^(−r²/2), whose spectrum is e^(−q²/2)."""
    r = np.maximum(r, 1e-9)
    return (
        np.sqrt(np.pi / 8) * r * (ive(0, r**2 / 4) - ive(1, r**2 / 4)),
        -2 * np.expm1(-(r**2) / 2) / r**2 - np.exp(-(r**2) / 2),
    )


def half_potential(r):
    """K₀, K₁ and K₂ of the same ρ: Weber's integrals of q^(3/2) … q^(1) times J₀ and J₁, over ⟨ζ²⟩ = √(π/2)."""
    x = r**2 / 2
    height = gamma(0.75) * 2**-0.25 * hyp1f1(0.75, 1.0, -x)
    turned = r * gamma(1.25) * 2**-0.75 * hyp1f1(1.25, 2.0, -x)
    own = np.sqrt(np.pi / 2) * ive(0, r**2 / 4)
    unit = np.sqrt(np.pi / 2)
    return height / np.sqrt(unit), turned / np.sqrt(unit), own / unit


def half_contact():
    """Contact on half of the area, with ρ = e^(−r²/2): ⟨FF′⟩ − ¼ = arcsin ρ/2π. The pressure is even there: F = G."""
    r = np.exp(np.arange(-2048, 2048) * 4e-3 + 2e-3)
    steps = np.array([0.0]), np.array([1.0])
    of_half = np.arcsin(np.exp(-(r**2) / 2)) / (2 * np.pi)
    return clipped.ClippedField(*steps, r, of_half, 0.25, clipped.products(*steps))


@cache
def rim_means():
    """θ, and over it ⟨FH′⟩, ⟨F_z H′⟩, sin θ⟨F_z H′_z⟩, ⟨HH′⟩ and sin θ⟨H_z H′_z⟩ by quadrature over z, z′ > 0."""
    points, weights = leggauss(24)
    ends = np.array([0.0, 0.05, 0.2, 0.6, 2.0, 8.0])
    half = np.diff(ends)[:, None] / 2
    x, w = (ends[:-1, None] + half * (1 + points)).ravel(), (half * weights).ravel()
    normal, steep = np.exp(-(x**2) / 2) * NORMAL, -1 / (x + 0.1) ** 2
    mean = 2 * w @ (normal / (x + 0.1))
    h, first = 1 / (x + 0.1) - mean, 10.0 - mean
    theta = np.append(0.0, np.linspace(0.12, np.pi - 1e-3, 300))
    rows = [
        (0.0, first * NORMAL / 2, first * NORMAL**2, w @ (normal * h**2), first**2 / (2 * np.pi))
    ]
    for angle in theta[1:]:
        s, p = np.sin(angle), np.cos(angle)
        narrow = np.exp(-((x / s) ** 2) / 2)
        pair = np.exp(-(x[:, None] ** 2 + x**2 - 2 * p * x[:, None] * x) / (2 * s**2)) / (2 * np.pi)
        alone = first + w @ (steep * narrow)
        edges = first**2 / (2 * np.pi) + first * (w @ (steep * narrow)) / np.pi
        rows.append(
            (
                w @ (normal * h * ndtr(p * x / s)),
                NORMAL**2 * (w @ (h * narrow)) / s,
                alone * NORMAL**2,
                (w * h) @ pair @ (w * h) / s,
                edges + (w * steep) @ pair @ (w * steep),
            )
        )
    return theta, np.array(rows).T


def orthant_means(part, own, other):
    """Means of `clipped.PAIRS` of F = 1(z > 0); `own` and `other` are places (x, y) of the heights of both bodies."""
    values = []
    for x, y in (own, other):
        r = np.hypot(x, y)
        first, second = riesz(r)
        cosine = np.where(r > 0, x / np.maximum(r, 1e-12), 0.0)
        rho = np.exp(-(r**2) / 2)
        height, turned, own_potential = half_potential(r)
        even = (rho - second * (2 * cosine**2 - 1)) / 2
        values.append((rho, first * cosine, even, height, turned * cosine, own_potential))
    (one, odd, even, level, turned, potential), (two, other_odd, other_even, *others) = values
    other_level, other_turned, other_potential = others
    p, k = (1 - part) * one + part * two, part * one + (1 - part) * two
    mixed = np.sqrt(part * (1 - part))
    m, s = mixed * (one - two), mixed * (odd - other_odd)
    n, c = (1 - part) * odd + part * other_odd, (1 - part) * even + part * other_even
    theta = np.arccos(p)
    density = 1 / (2 * np.pi * np.maximum(np.sin(theta), 1e-9))
    both = 0.5 - theta / (2 * np.pi)
    angles, of_rim = rim_means()
    with_rim, edge, across, rims, rim_edges = (np.interp(theta, angles, row) for row in of_rim)
    across, rim_edges = (row * density * 2 * np.pi for row in (across, rim_edges))
    a = float(half_potential(np.array(0.0))[0])
    mean = 2 * a * NORMAL  # ⟨Fζ⟩/⟨F⟩
    h = mixed * (level - other_level)
    level = (1 - part) * level + part * other_level
    turned = (1 - part) * turned + part * other_turned
    potential = (1 - part) * potential + part * other_potential
    # with F_z = δ(z): z F_z = 0, and ⟨F_zz F′⟩ = −p⟨F_z F′_z⟩
    along = (level - a * p) * density
    uneven = (level + a) * NORMAL / 2
    of_shares = {
        (0, 0): both - 0.25,
        (0, 2): m * NORMAL / 2,
        (0, 3): m * edge,
        (2, 2): k * both + m**2 * density,
        (2, 3): k * with_rim + m**2 * across,
        (3, 3): k * rims + m**2 * rim_edges,
        (0, 4): n * NORMAL / 2,
        (2, 4): s * both + n * m * density,
        (3, 4): s * with_rim + n * m * across,
        (4, 4): c * both - n**2 * density,
        (0, 5): uneven - mean * both,
        (2, 5): h * both + m * along - mean * m * NORMAL / 2,
        (3, 5): h * with_rim + m * (level - a * p) * across - mean * m * edge,
        (5, 4): turned * both + n * along - mean * n * NORMAL / 2,
        (5, 5): potential * both
        + (a**2 + level**2 - 2 * a * level * p) * density
        - 2 * mean * uneven
        + mean**2 * both,
    }
    nothing = np.zeros_like(both)  # the even share of an even pressure
    return np.array([*(of_shares.get(pair, nothing) for pair in clipped.PAIRS), both - 0.25])


FAR = (np.array(1e3), np.array(0.0))
OF_RIM = np.array([2 if pair == (3, 3) else 1 for pair in (*clipped.PAIRS, None)])  # 48 steps
TURNS = (np.arange(720) + 0.5) * 2 * np.pi / 720


@pytest.mark.parametrize("part", [0.5, 0.2])
def test_products_with_earlier_heights_are_orthant_means_over_all_directions(part):
    field = half_contact()
    place = np.array([0.0, 0.3, 0.7, 1.2, 2.0, 3.1])
    nearer = np.array([0.05, 0.1])
    transforms = (
        np.exp(-(field.distance**2) / 2),
        *riesz(field.distance),
        *half_potential(field.distance),
    )
    seen = memory.seen_pairs(field, transforms, part, place, nearer)
    middle = np.searchsorted(field.distance, [0.2, 1.0, 2.5])
    for n in middle:
        r = field.distance[n]
        circle = r * np.cos(TURNS), r * np.sin(TURNS)
        alone, passed = orthant_means(part, circle, FAR), orthant_means(part, FAR, circle)
        # of the table of products
        np.testing.assert_array_less(np.abs(seen.own[:, n] - alone.mean(axis=1)), 2e-4 * OF_RIM)
        for k in range(3):
            term = (passed * np.cos(k * TURNS)).mean(axis=1) * (1 if k == 0 else 2)
            np.testing.assert_allclose(seen.other[k, :, n], term, atol=2e-4)
    for i, r in enumerate(place):
        for j, s in enumerate(place):
            here = r * np.cos(TURNS), r * np.sin(TURNS)
            there = here[0] + s, here[1]
            whole = orthant_means(part, here, there).mean(axis=1)
            each = orthant_means(part, here, FAR) + orthant_means(part, FAR, there)
            found = seen.both[:, i, j + nearer.size if j else 0]
            # 20 directions; worst at r = s, with one direction in which both places meet
            off = np.abs(found - (whole - each.mean(axis=1)))
            np.testing.assert_array_less(off, 1e-3 * OF_RIM, err_msg=f"r = {r}, s = {s}")
    # linear from the first place to the second
    slope = (seen.both[..., 1] - seen.both[..., 0]) / nearer[0]
    np.testing.assert_allclose(seen.both[..., 2], seen.both[..., 0] + slope * nearer[1], atol=1e-12)
    np.testing.assert_allclose(seen.both[..., 3], seen.both[..., 0] + slope * place[1], atol=1e-12)


@pytest.mark.parametrize("part", [0.3, 1.0])
def test_each_body_keeps_its_share_of_what_the_law_lacks(part):
    # ⟨FF′⟩_c = arcsin(p)/2π of its greatest, ¼; at r = 0 p is 1 − f alone, f alone, and 1 − f + fρ(s) together
    field = half_contact()
    place, nearer = np.array([0.0, 0.3, 0.7, 1.2, 2.0]), np.array([0.05, 0.1])
    transforms = (
        np.exp(-(field.distance**2) / 2),
        *riesz(field.distance),
        *half_potential(field.distance),
    )
    off = -0.02 * field.distance**2 * np.exp(-(field.distance**2) / 8)
    field = replace(field, pressure_correlation=field.pressure_correlation + off)
    seen = memory.seen_pairs(field, transforms, part, place, nearer)
    kept, passed = (2 / np.pi * np.arcsin(p) for p in (1 - part, part))
    np.testing.assert_allclose(seen.own[-1] - seen.own[0], kept * off, atol=5e-5)
    of_orders = np.array([passed, 0.0, 0.0])[:, None] * off
    np.testing.assert_allclose(seen.other[:, -1] - seen.other[:, 0], of_orders, atol=5e-5)
    rho = np.exp(-(place**2) / 2)
    together = 2 / np.pi * (np.arcsin(1 - part + part * rho) - np.arcsin(part * rho)) - kept
    found = np.delete(seen.both[-1] - seen.both[0], [1, 2], axis=1)  # but between the first two
    there = -0.02 * place**2 * np.exp(-(place**2) / 8)
    np.testing.assert_allclose(found, there[:, None] * together, atol=5e-5)
