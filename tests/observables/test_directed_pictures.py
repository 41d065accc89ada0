"""Pictures of faces with a lay, in single directions: waves by quadrature of their own, pictures by hand."""

from math import inf, log, pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.ndimage import fourier_gaussian, gaussian_filter
from scipy.optimize import brentq
from scipy.special import ndtr, wofz
from small_scene import CAPPED

import roughsim as rs
from roughsim import Grid, HeatSource
from roughsim.heat.camera import Lens
from roughsim.heat.periodic import MovingSource, unit_vector
from roughsim.observables.camera import Camera, correlations_of, distances, hottest_of, pictures
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.observables.directed_pictures import correlation_across, mean_squares_of_waves
from roughsim.observables.record import Sample
from roughsim.observables.stress_spectrum import gathering, stress_spectrum
from roughsim.prediction.camera import camera_of, of_level, side_of
from roughsim.results.heated import Way, seen
from roughsim.scene import parse_scene
from roughsim.scene.numerics import Numerics
from theory.camera import View, seen_rms, seen_width

D = 7.6e-6
GRID = Grid((48, 40), (3e-3, 1e-3))
LOOKS = {
    "sharp": Lens(),
    "blurred": Lens(resolution=30e-6),
    "smeared": Lens(30e-6, 4e-4),
    "behind": Lens(30e-6, 0.0, 1e-4, 1e-3),
}
ANGLES = [0.0, 0.4, pi / 4, 1.3, pi / 2]


def source(angle, speed=0.3, lens=None, slid=inf):
    rate, (ux, uy) = speed / D, unit_vector(angle)
    return MovingSource((rate * ux, rate * uy), slid / rate, lens=lens)


def power(qx, qy, angle, speed, lens, slid):
    """|κT/q̇|² of waves as the camera sees them, by the formulas of the page."""
    rate, (ux, uy) = speed / D, unit_vector(angle)
    along, across = ux * qx + uy * qy, ux * qy - uy * qx
    if lens.behind is not None:
        decay = across**2 / rate - 1j * along
        ends = [_erfc(np.sqrt(decay * at)) for at in (lens.behind, lens.behind + 1e-3)]
        response, blurred = (ends[0] - ends[1]) / np.sqrt(decay * rate), across**2
    else:
        root = np.sqrt(along**2 + across**2 - 1j * along * rate)
        grown = 1.0 if slid == inf else 1 - _erfc(root * sqrt(slid / rate))
        phase = along * lens.smear / 2
        response = (
            grown / root * np.where(phase == 0, 1.0, np.sin(phase) / np.where(phase, phase, 1))
        )
        blurred = along**2 + across**2
    return np.abs(response) ** 2 * np.exp(-blurred * lens.resolution**2 / (8 * log(2)))


def _erfc(z):
    return np.exp(-(z**2)) * wofz(1j * z)


def boxes(grid, angle, speed, lens, slid, points=(8, 240)):
    """Means over the boxes of waves: Gauss across sliding, and many points on the side that is longer along it."""
    qx, qy = grid.wavevectors
    dx, dy = grid.mode_spacing
    nodes, weights = np.polynomial.legendre.leggauss(points[0])
    many = (np.arange(points[1]) + 0.5) / points[1] - 0.5
    swapped = abs(np.cos(angle)) * dx < abs(np.sin(angle)) * dy
    found = np.zeros(grid.half_shape)
    for node, weight in zip(nodes / 2, weights / 2, strict=True):
        aside = (node * dx, many * dy) if swapped else (many * dx, node * dy)
        x, y = (q[..., None] + part for q, part in zip((qx, qy), aside, strict=True))
        found += weight * power(x, y, angle, speed, lens, slid).mean(axis=-1)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("name", LOOKS)
def test_waves_stand_for_their_boxes(name, angle):
    small, lens = Grid((12, 10), (9e-4, 3e-4)), LOOKS[name]
    for slid in (inf, 5e-4):
        if lens.behind is not None and slid < inf:
            continue
        found = mean_squares_of_waves(small, source(angle, 0.3, lens, slid))
        exact = boxes(small, angle, 0.3, lens, slid)
        # boxes that touch q = 0 at a corner have its 1/q beside them
        np.testing.assert_allclose(
            found[2:-2, 2:-1], exact[2:-2, 2:-1], rtol=5e-3, atol=1e-4 * exact[3, 3]
        )


@pytest.mark.parametrize("name", LOOKS)
def test_row_across_sliding_is_its_integral(name):
    lens, speed = LOOKS[name], 35.0
    found = mean_squares_of_waves(GRID, source(0.0, speed, lens))
    width, step = (spacing / 2 for spacing in GRID.mode_spacing)
    for k in (3, 9):
        qy = GRID.wavevectors[1][0, k]

        def one(x, aside, qy=qy):
            return (
                float(power(np.array(10.0**x), qy + aside, 0.0, speed, lens, inf)) * 10**x * log(10)
            )

        points, weights = np.polynomial.legendre.leggauss(6)
        exact = sum(
            weight / 2 * quad(one, -6, np.log10(width), args=(step * point,), limit=200)[0]
            for point, weight in zip(points, weights, strict=True)
        )
        assert found[0, k] == pytest.approx(exact / width, rel=1e-3)


class Bump:
    """|σ_q|², Pa² m², about 5e4 rad/m."""

    breaks = (1e4, 9e4)

    def __call__(self, q):
        return 1e4 * np.exp(-(((q - 5e4) / 1e4) ** 2))


@pytest.mark.parametrize("angle", [0.0, 0.4, pi / 2])
@pytest.mark.parametrize("name", ["blurred", "smeared"])
def test_boxes_add_up_to_the_integral_of_theory(name, angle):
    # an isotropic stress in a stretched cell, whose boxes are not square
    grid, lens, speed = Grid((160, 96), (4e-3, 1.3e-3)), LOOKS[name], 35.0
    q = grid.wavenumbers
    dx, dy = grid.mode_spacing
    variance = np.where((q > 1e4) & (q < 9e4), Bump()(q), 0.0) * dx * dy * grid.multiplicity
    y = distances(1e-3)
    (found,) = correlation_across(variance, grid, [source(angle, speed, lens)], y)
    view = View(lens.resolution, lens.smear)
    stress = {"stress_spectrum": Bump(), "nominal_pressure": 1e8, "view": view}
    heat = {"friction_coefficient": 0.11, "conductivity": 30.0, "diffusivity": D}
    rms = seen_rms(speed, **stress, **heat) * 30 / (0.11 * speed)
    assert sqrt(found[0]) == pytest.approx(rms, rel=2e-3)
    half = np.interp(-0.5, -found[:25] / found[0], y[:25])
    assert 2 * half == pytest.approx(seen_width(speed, **stress, **heat), rel=0.03)


def contact(grid, seed=0):
    """Spots of pressure without waves at the Nyquist wavenumbers."""
    noise = np.random.default_rng(seed).standard_normal(grid.shape)
    pressure = np.maximum(gaussian_filter(noise, 1.5, mode="wrap"), 0.1) - 0.1
    wave = np.fft.fft2(pressure)
    wave[grid.shape[0] // 2] = wave[:, grid.shape[1] // 2] = 0.0
    return 1e9 * np.fft.ifft2(wave).real


def camera_at(angles, lens, speed=35.0, slid=None):
    sources = tuple(source(angle, speed, lens) for angle in angles)
    return Camera(sources, (0.11 * speed / 30,) * len(angles), tuple(angles), slid, directed=True)


def sliding_at(angles, speed=35.0):
    return HeatSource((speed,) * len(angles), 0.11, 30.0, D, direction=tuple(angles))


def test_turned_cell_turns_the_picture():
    pressure, lens = contact(GRID), LOOKS["smeared"]
    turned = Grid(GRID.shape[::-1], GRID.lengths[::-1])
    for one, other in ((0.4, pi / 2 - 0.4), (pi / 2, 0.0)):
        curves, numbers = [], []
        for field, grid, angle in ((pressure, GRID, one), (pressure.T, turned, other)):
            camera = camera_at([angle], lens)
            spectrum, _ = stress_spectrum(np.fft.rfft2(field) / field.size, grid, gathering(grid))
            curves.append(correlations_of(field, grid, camera))
            numbers.append(hottest_of(field, grid, spectrum, sliding_at([angle]), camera))
        np.testing.assert_allclose(*curves, rtol=1e-5, atol=1e-6 * curves[0][0, 0])
        np.testing.assert_allclose(*numbers, rtol=1e-5)


@pytest.mark.parametrize("angle", ANGLES)
def test_single_wave_is_blurred_by_its_true_length(angle):
    nx, ny = GRID.shape
    k, resolution = np.array([5, 3]), 40e-6
    x, y = np.meshgrid(np.arange(nx) / nx, np.arange(ny) / ny, indexing="ij")
    pressure = 1e8 * (1 + 0.5 * np.cos(2 * pi * (k[0] * x + k[1] * y)))
    camera = camera_at([angle], Lens(resolution), 1e-4)
    (field,) = pictures(pressure, GRID, sliding_at([angle], 1e-4), camera)
    q = sqrt(sum((2 * pi * n / length) ** 2 for n, length in zip(k, GRID.lengths, strict=True)))
    amplitude = 0.5 / q * np.exp(-((q * resolution) ** 2) / (16 * log(2)))
    assert field.max() == pytest.approx(
        amplitude, rel=1e-2
    )  # points beside the crest, and 1e-4 m/s
    assert sqrt(2 * np.mean(field**2.0)) == pytest.approx(amplitude, rel=1e-4)
    (curve,) = correlations_of(pressure, GRID, camera)
    qx, qy = (2 * pi * n / length for n, length in zip(k, GRID.lengths, strict=True))
    y = distances(sqrt(GRID.lengths[0] ** 2 + GRID.lengths[1] ** 2) / 2)
    across = qy * np.cos(angle) - qx * np.sin(angle)
    np.testing.assert_allclose(curve / curve[0], np.cos(across * y), atol=6e-3)


def test_hottest_part_counts_older_heat():
    speed, angle, lens = 5.0, 0.0, LOOKS["blurred"]
    pressure, rate = contact(GRID), speed / D
    wave = np.fft.rfft2(pressure) / GRID.points
    variance = np.abs(wave) ** 2 * GRID.multiplicity
    variance[0, 0] = 0.0
    chord = GRID.lengths[0]
    whole, young = (
        float(np.sum(variance * boxes(GRID, angle, speed, lens, slid, (2, 240))))
        for slid in (inf, chord / 2)
    )
    # the picture from rest over half the chord
    qx, qy = GRID.wavevectors
    square = qx**2 + qy**2
    square[0, 0] = 1.0
    root = np.sqrt(square - 1j * rate * qx)
    response = (1 - _erfc(root * sqrt(chord / 2 / rate))) / root
    response *= np.exp(-square * lens.resolution**2 / (16 * log(2)))
    response[0, 0] = 0.0
    field = np.fft.irfft2(wave * response, GRID.shape) * GRID.points
    older = whole / young - 1
    assert older > 0.02
    own = field.std()

    def hotter(value):
        return float(np.mean(ndtr((field - value) / (own * sqrt(older))))) - 0.01

    hottest = brentq(hotter, 0.0, 10 * own) / (own * sqrt(1 + older))
    spectrum, _ = stress_spectrum(wave, GRID, gathering(GRID))
    found = hottest_of(
        pressure, GRID, spectrum, sliding_at([angle], speed), camera_at([angle], lens, speed)
    )
    assert found[0] == pytest.approx(0.11 * speed / 30 * sqrt(whole) * hottest, rel=5e-3)


FREE = CAPPED.replace("lengths = [2e-3, 2e-3]\n", "")
GROOVED = FREE.replace("[surface]\n", "[surface]\nlay = 3\n")
LEVELS = parse_scene(CAPPED).numerics.levels


def pictured(camera='resolution = "30 um"', text=GROOVED):
    return parse_scene(text.replace("[theory]", f"[camera]\n{camera}\n[theory]"))


def test_field_is_the_blurred_temperature():
    scene, grid, pressure = pictured(), GRID.stretched(1.0), contact(GRID)
    way = Way(35.0, 1.3, 3e-4)
    heat = {"speed": 35.0, "conductivity": 30.0, "diffusivity": 30 / (7900 * 500)}
    sharp = rs.sliding_temperature(
        0.11 * 35.0 * 0.9 * pressure, grid, direction=1.3, slid_distance=3e-4, **heat
    )
    sigma = 30e-6 / sqrt(8 * log(2)) / np.array(grid.spacing)
    blurred = np.fft.ifft2(fourier_gaussian(np.fft.fft2(sharp), sigma)).real
    np.testing.assert_allclose(
        seen(scene, pressure, grid, way, 0.9), blurred, atol=1e-5 * np.abs(blurred).max()
    )


@pytest.fixture(scope="module")
def member():
    scene = pictured(text=GROOVED.replace("speed = [0, 0.1, 35]", "speed = [0, 0.1]"))
    numerics = Numerics(LEVELS, (2e-3, 2e-3), tolerance=1e-5)
    return scene, rs.realize(scene, numerics, seed=3, level=1)


def test_member_sums_the_waves_of_its_stress(member):
    scene, solved = member
    wave = np.fft.rfft2(solved.contact.pressure) / solved.grid.points
    variance = np.abs(wave) ** 2 * solved.grid.multiplicity
    variance[0, 0] = 0.0
    heated = 0.11 * 0.1 / 30
    for k, angle in ((1, 0.0), (3, pi / 4), (5, pi / 2)):
        # some points of a box suffice at .1 m/s
        squares = boxes(solved.grid, angle, 0.1, Lens(30e-6), inf, (2, 16))
        found = solved.seen_correlations[k]
        assert found[0] == pytest.approx(float(np.sum(variance * squares)), rel=3e-3)
        assert sqrt(found[0]) * heated == pytest.approx(
            camera_of(scene).heating[k] * sqrt(found[0]), rel=0.01
        )
        assert np.abs(found[1:]).max() < found[0]


def test_hottest_is_zero_at_rest(member):
    _, solved = member
    assert solved.seen_99.shape == (6,)
    np.testing.assert_allclose(solved.seen_99[[0, 2, 4]], 0.0, atol=1e-100)
    rms = np.sqrt(solved.seen_correlations[1::2, 0]) * 0.11 * 0.1 / 30
    assert (solved.seen_99[1::2] > 2 * rms).all()


def test_level_has_rms_and_width_of_its_waves():
    # of one wave with the wavenumber q across sliding, C(y) = cos(qy): halved at qy = π/3
    scene = pictured(text=GROOVED.replace("speed = [0, 0.1, 35]", "speed = [1, 35]"))
    reach, q = 1e-3, np.array([9e3, 1e4, 1.1e4, 1.2e4, 1.3e4, 2e4])
    curves = 1e-6 * np.cos(q * distances(reach)[:, None])  # (distances, cases)
    numbers = {
        f"seen_correlation_{k}": np.stack([curve, 3 * curve]) for k, curve in enumerate(curves)
    }
    sample = Sample(inf, 0, np.arange(2), numbers, np.empty(0), np.empty((2, 0)), reach)
    rms, width = (of_level(scene, OBSERVABLES[name], sample) for name in ("seen_rms", "seen_width"))
    heating = 0.11 / 30 * np.array([1.0, 35.0] * 3)
    np.testing.assert_allclose(rms.mean(axis=0), heating * sqrt(2e-6), rtol=1e-12)
    np.testing.assert_allclose(width.mean(axis=0), 2 * pi / 3 / q, rtol=2e-3)


def test_blur_over_a_stretched_cell_is_unknown():
    scene = pictured('resolution = "600 um"')
    x, y = Grid((1, 1), (1e-3, 1e-3)).stretched(3.0).lengths  # y = 577 µm
    sample = Sample(inf, 0, np.arange(2), {}, np.empty(0), np.empty((2, 0)), sqrt(x**2 + y**2) / 2)
    assert np.isnan(of_level(scene, OBSERVABLES["seen_rms"], sample)).all()


def test_side_of_a_stretched_cell_is_the_shorter():
    x, y = Grid((1, 1), (2e-3, 2e-3)).stretched(5.0).lengths
    assert side_of(sqrt(x**2 + y**2), 5.0) == pytest.approx(y, rel=1e-12)
