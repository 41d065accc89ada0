"""Contact: the lawful and the unlawful problems, each once, with what is known about its solution.

All are judged by their optimality conditions from outside; most live on 64 × 64 points of the unit cell with E* = 1.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from contact_cases import (
    UNIT,
    WAVE,
    WAVE_PRESSURE,
    displacement_by_dft,
    press,
    q_plane,
    rough,
    violation,
)
from some_rows import some

import roughsim as rs

ROUGH, _ = rough()
RNG = np.random.default_rng(5)


@dataclass(frozen=True)
class Case:
    """One problem, and what is known: contact fraction (to a pixel at each edge of each ridge), highest pressure."""

    heights: object
    load: float = 0.01
    hardness: float = np.inf
    grid: rs.Grid = UNIT
    modulus: float = 1.0
    fraction: float | None = None
    highest: float | None = None
    ridges: int = 1


def along_x(waves=1, points=64):
    return 0.01 * np.cos(2 * np.pi * waves * np.arange(points) / points)[:, None] * np.ones((1, 64))


def full_load(heights, grid=UNIT):
    """The lowest load of full contact."""
    return -np.fft.ifft2(np.fft.fft2(heights) * q_plane(grid) / 2).real.min()


def westergaard(fraction):
    return 2 / np.pi * np.arcsin(np.sqrt(min(fraction, 1.0)))


def exact_waves():
    cases = {}
    for fraction in (
        1e-6,
        1e-3,
        0.01,
        0.1,
        0.3,
        0.5,
        0.7,
        0.9,
        0.99,
        0.999,
        0.999999,
        1.0,
        1.0 + 1e-9,
        1.001,
        2.0,
        10.0,
    ):
        highest = (1 + fraction) * WAVE_PRESSURE if fraction >= 1 else None
        cases[f"wave at {fraction:.9g} of full contact"] = Case(
            WAVE, fraction * WAVE_PRESSURE, fraction=westergaard(fraction), highest=highest
        )
    cases["wave along y"] = replace(cases["wave at 0.5 of full contact"], heights=WAVE.T)
    cases["four ridges tied"] = Case(along_x(4), 2 * WAVE_PRESSURE, fraction=0.5, ridges=4)
    cases["thirty-two ridges tied"] = Case(
        along_x(32), 0.5 * 32 * WAVE_PRESSURE, fraction=0.5, ridges=4
    )
    for shape in ((64, 1), (1, 64)):
        heights = WAVE[:, :1].reshape(shape)
        cases[f"wave on {shape}"] = Case(
            heights, WAVE_PRESSURE / 2, grid=rs.Grid(shape, (1.0, 1.0)), fraction=0.5
        )
    return cases


def shapes_of_the_surface():
    plateau, step, ridge = np.zeros((64, 64)), np.zeros((64, 64)), np.zeros((64, 64))
    plateau[20:40, 25:45] = step[:32] = 0.01
    ridge[np.arange(64), -np.arange(64)] = 0.01
    x = np.arange(64) / 64 - 0.5
    q = np.hypot(np.fft.fftfreq(64)[:, None], np.fft.rfftfreq(64)) * 128 * np.pi
    ring = np.fft.irfft2(np.exp(2j * np.pi * RNG.random(q.shape)) * (np.abs(q - 16 * np.pi) < 2))
    cases = {
        "flat": Case(np.full((64, 64), 0.3), 1e-3, fraction=1.0, highest=1e-3),
        "plateau": Case(plateau),
        "step": Case(step),
        "diagonal ridge of ties": Case(ridge, 1e-7, fraction=1 / 64, highest=6.4e-6),
        "one peak": Case(np.where((np.indices((64, 64)) == 7).all(axis=0), 0.1, 0.0)),
        "one pit": Case(np.where((np.indices((64, 64)) == 7).all(axis=0), -0.1, 0.0), 0.1),
        "paraboloid": Case(-np.add.outer(x**2, x**2) / 2),
        "cone": Case(-np.hypot(*np.meshgrid(x, x)) / 10),
        "checkerboard": Case(0.01 * (np.indices((64, 64)).sum(axis=0) % 2)),
        "white noise": Case(0.01 * RNG.standard_normal((64, 64)), 0.05),
        "ring of waves": Case(0.01 * ring / ring.std(), 0.05),
        "lognormal": Case(0.01 * np.exp(RNG.standard_normal((64, 64))), 0.05),
        "a few levels": Case(np.round(ROUGH / np.ptp(ROUGH) * 5) / 100),
        "slope 10": Case(rough(slope=10.0, per_wave=2)[0], 1.0),
        "slope 1e-8": Case(rough(slope=1e-8)[0], 1e-9),
    }
    for hurst in (0.0, 0.05, 0.5, 1.0):
        cases[f"H = {hurst:g} without a short cut-off"] = Case(rough(hurst=hurst, per_wave=2)[0])
    steep = 0.01 * np.fft.irfft2(
        np.fft.rfft2(RNG.standard_normal((64, 64))) / np.maximum(q, 2 * np.pi) ** 2.2
    )
    cases["H = 1.2, roll-off at the cell"] = Case(steep / steep.std() / 100, 1e-3)
    for over in (0.9, 0.999, 0.99999, 1.0, 1.0001, 3.0):
        cases[f"rough at {over:g} of full contact"] = Case(
            ROUGH, over * full_load(ROUGH), fraction=1.0 if over >= 1 else None
        )
    return cases


def loads_and_hardnesses():
    cases = {}
    for load in (1e-300, 1e-100, 1e-30, 1e-16, 1e-12, 1e-8, 1e-4, 0.1, 1.0, 1e3, 1e6):
        cases[f"load {load:g} E*"] = Case(ROUGH, load, fraction=1 / 4096 if load < 1e-7 else None)
        if load > 1e-300:
            cases[f"load {load:g} E*, hardness of twice that"] = Case(ROUGH, load, 2 * load)
    for ratio in (1.0, 1.0 + 1e-9, 1.0001, 1.01, 1.1, 1.5, 5.0, 20.0, 100.0, 1e6):
        highest = 0.01 if ratio == 1.0 else None
        cases[f"hardness {ratio:.9g} of the load"] = Case(
            ROUGH, 0.01, ratio * 0.01, fraction=1.0 if ratio == 1 else None, highest=highest
        )
    cases["hardness far below E*: the bearing area"] = Case(
        100 * ROUGH, 1e-5, 1e-4, fraction=0.1, highest=1e-4
    )
    cases["slope 2, most of the contact yielded"] = Case(rough(slope=2.0)[0], 0.1, 0.15)
    return cases


def grids():
    cases = {}
    for shape, lengths in (
        ((63, 63), (1.0, 1.0)),
        ((64, 128), (1.0, 2.0)),
        ((64, 64), (1.0, 3.0)),
        ((64, 64), (1000.0, 1.0)),
        ((64, 64), (1.0, 1000.0)),
        ((127, 64), (1.0, 1.0)),
        ((61, 67), (1.0, 1.0)),
        ((128, 128), (1.0, 1.0)),
        ((97, 89), (1.0, 500.0)),
        ((2, 2), (1.0, 1.0)),
        ((3, 3), (1.0, 1.0)),
        ((4, 3), (1.0, 1.0)),
        ((1, 61), (1.0, 1.0)),
        ((1, 257), (1.0, 1.0)),
        ((251, 1), (1.0, 1e-3)),
        ((2, 300), (1.0, 1.0)),
        ((8, 1024), (1.0, 1.0)),
    ):
        grid, noise = rs.Grid(shape, lengths), RNG.standard_normal(shape)
        q = np.hypot(np.fft.fftfreq(shape[0])[:, None] * shape[0], np.arange(shape[1] // 2 + 1))
        falling = np.fft.irfft2(np.fft.rfft2(noise) * np.maximum(q, 1) ** -1.8 * (q > 0), s=shape)
        for name, heights in (("rough", falling / falling.std()), ("noise", noise)):
            level = np.abs(np.fft.ifft2(np.fft.fft2(heights) * q_plane(grid) / 2).real).max()
            for word, share, cap in (
                ("low", 1e-3, np.inf),
                ("middle", 0.1, np.inf),
                ("capped", 0.1, 0.25),
            ):
                cases[f"{name} on {shape} of {lengths}, {word}"] = Case(
                    heights, share * level, cap * level, grid
                )
    cases["one point"] = Case(
        np.ones((1, 1)), 1e-3, grid=rs.Grid((1, 1), (1.0, 1.0)), fraction=1.0, highest=1e-3
    )
    cases["512 × 512"] = Case(*_large())
    return cases


def _large():
    heights, grid = rough(512, per_wave=4)
    return heights, 0.01, np.inf, grid


def units():
    cases = {}
    for length, pressure in (
        (1e-9, 1.0), (1e9, 1.0), (1.0, 1e9), (1.0, 1e-9), (1e3, 1e11), (1e-9, 1e-9), (1e9, 1e9), (1e-100, 1.0),
        (1e100, 1.0), (1.0, 1e160), (1.0, 1e-100), (1e-6, 1e11),
    ):  # fmt: skip
        grid = rs.Grid((64, 64), (length, length))
        cases[f"lengths × {length:g}, pressures × {pressure:g}"] = Case(
            ROUGH * length, 0.01 * pressure, 0.05 * pressure, grid, pressure
        )
    for offset in (1.0, -1.0, 1e3, -1e3, 1e6, 1e9, -1e9):
        cases[f"heights {offset:+g}"] = Case(ROUGH + offset)
    return cases


def forms():
    whole = np.rint(ROUGH * 1e6)
    padded = np.zeros((128, 128))
    padded[::2, ::2] = whole
    frozen = whole.copy()
    frozen.flags.writeable = False
    forms = {
        "int64": whole.astype(np.int64),
        "int32": whole.astype(np.int32),
        "float32": whole.astype(np.float32),
        "float16": ROUGH.astype(np.float16) * np.float16(64),
        "long double": whole.astype(np.longdouble),
        "big-endian": whole.astype(">f8"),
        "uint8": ((whole - whole.min()) / np.ptp(whole) * 255).astype(np.uint8),
        "truth values": whole > 0,
        "Fortran order": np.asfortranarray(whole),
        "every other point": padded[::2, ::2],
        "backwards": whole[::-1, ::-1],
        "read-only": frozen,
        "lists": whole.tolist(),
        "a matrix's transpose": whole.T,
    }
    return {
        f"heights as {name}": Case(form, 0.03 * max(float(np.ptp(np.asarray(form, float))), 0.1))
        for name, form in forms.items()
    }


def moved():
    return {
        "shifted": Case(np.roll(ROUGH, (5, -11), (0, 1)), hardness=0.05),
        "turned by a right angle": Case(np.rot90(ROUGH), hardness=0.05),
        "mirrored": Case(ROUGH[::-1], hardness=0.05),
        "tiled 2 × 2": Case(
            np.tile(ROUGH, (2, 2)), hardness=0.05, grid=rs.Grid((128, 128), (2.0, 2.0))
        ),
    }


LAWFUL = {
    **exact_waves(),
    **shapes_of_the_surface(),
    **loads_and_hardnesses(),
    **grids(),
    **units(),
    **forms(),
    **moved(),
}


@pytest.mark.parametrize("name", some(LAWFUL))
def test_a_lawful_problem_is_solved(name):
    case = LAWFUL[name]
    heights, solid = np.asarray(case.heights, float), rs.Solid(case.modulus, case.hardness)
    contact = rs.solve_contact(case.heights, case.grid, solid, nominal_pressure=case.load)
    pressure = contact.pressure
    assert pressure.mean() == pytest.approx(case.load, rel=1e-12)
    assert pressure.min() >= 0.0
    assert pressure.max() <= case.hardness
    if np.ptp(heights) > 0:
        assert worst(heights, case, pressure) <= 1e-6
    if case.fraction is not None:
        assert contact.contact_fraction == pytest.approx(
            case.fraction, abs=2 * case.ridges / max(case.grid.shape)
        )
    if case.highest is not None:
        assert pressure.max() == pytest.approx(case.highest, rel=1e-9)


def worst(heights, case, pressure):
    """The violation in units in which neither lengths nor pressures overflow when squared."""
    length, side = np.abs(heights).max(), max(case.grid.lengths)
    unit = case.modulus * (np.ptp(heights) / side)
    grid = rs.Grid(case.grid.shape, tuple(part / side for part in case.grid.lengths))
    solid = rs.Solid(1.0, case.hardness / unit)
    return violation(heights / np.ptp(heights), grid, solid, pressure / unit) if length else 0.0


def test_full_contact_of_a_rough_surface_is_the_closed_form_to_the_ninth_digit():
    load = 1.3 * full_load(ROUGH)
    full = np.fft.ifft2(np.fft.fft2(ROUGH) * q_plane(UNIT) / 2).real
    np.testing.assert_allclose(press(ROUGH, nominal_pressure=load).pressure, load + full, rtol=1e-9)


def test_a_tolerance_out_of_reach_stops_at_the_rounding_floor_and_says_so():
    with pytest.warns(RuntimeWarning, match="tolerance = 1e-30 lies below the rounding floor"):
        contact = press(ROUGH, tolerance=1e-30)
    assert violation(ROUGH, UNIT, rs.Solid(1.0), contact.pressure) <= 1e-12
    np.testing.assert_allclose(
        contact.displacement, displacement_by_dft(contact.pressure, UNIT, 1.0), atol=1e-15
    )
