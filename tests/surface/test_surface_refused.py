"""Surfaces: spectra and draws refuse arguments without meaning by name and value with unit."""

from functools import partial

import numpy as np
import pytest
from refused_cases import assert_refused
from surface_cases import SPECTRUM, square

from roughsim.surface.power_laws import SelfAffineSpectrum, TabulatedSpectrum
from roughsim.surface.synthesis import synthesize

NAN, INF = float("nan"), float("inf")
GOOD = {"hurst": 0.8, "q_min": 1e3, "q_roll_off": 1e4, "q_max": 1e6, "roll_off_exponent": 1.5}
SELF_AFFINE = {
    r"hurst = -0\.1 must lie in \[0, 1\]": {"hurst": -0.1},
    r"hurst = 1\.01 must lie in \[0, 1\]": {"hurst": 1.01},
    "hurst = nan must be finite": {"hurst": NAN},
    "hurst = '0.8' must be one real number": {"hurst": "0.8"},
    r"hurst = \[0.8\] must be one real number": {"hurst": [0.8]},
    "hurst = None must be one real number": {"hurst": None},
    "hurst = True must be one real number": {"hurst": True},
    r"q_min = 1e\+06 rad/m must be below q_max = 1e\+06": {"q_min": 1e6, "q_roll_off": 1e6},
    r"q_min = 2e\+06 rad/m must be below q_max = 1e\+06 rad/m": {"q_min": 2e6},
    "q_min = 0 rad/m must be positive": {"q_min": 0},
    "q_min = -1000 rad/m must be positive": {"q_min": -1e3},
    "q_min = nan rad/m must be finite": {"q_min": NAN},
    "q_max = inf rad/m must be finite": {"q_max": INF},
    "q_max = '1e6' must be one real number in rad/m": {"q_max": "1e6"},
    "q_roll_off = 900 rad/m must lie between q_min = 1000 and q_max": {"q_roll_off": 900.0},
    r"q_roll_off = 2e\+06 rad/m must lie between q_min = 1000": {"q_roll_off": 2e6},
    "q_roll_off = nan rad/m must be finite": {"q_roll_off": NAN},
    "q_roll_off = -1 rad/m must be positive": {"q_roll_off": -1.0},
    "roll_off_exponent = inf must be finite": {"roll_off_exponent": INF},
    "roll_off_exponent = 1j must be one real number": {"roll_off_exponent": 1j},
}
TABLES = {
    "q = 2 rad/m follows q = 3 rad/m and must exceed it": ([1.0, 3.0, 2.0], [1.0, 1.0, 1.0]),
    "q = 1 rad/m follows q = 1 rad/m and must exceed it": ([1.0, 1.0], [1.0, 1.0]),
    "psd holds 0.0 m⁴": ([1.0, 2.0], [1.0, 0.0]),
    "psd holds -2.0 m⁴": ([1.0, 2.0], [1.0, -2.0]),
    "psd holds nan m⁴": ([1.0, 2.0], [NAN, 1.0]),
    "q holds inf rad/m": ([1.0, INF], [1.0, 1.0]),
    "q holds 0.0 rad/m": ([0.0, 2.0], [1.0, 1.0]),
    "q has 2 points but psd has 3": ([1.0, 2.0], [1.0, 1.0, 1.0]),
    r"q has shape \(1,\)": ([1.0], [1.0]),
    r"q has shape \(1, 2\)": ([[1.0, 2.0]], [[1.0, 1.0]]),
    "q is a list of dtype <U1; .* real numbers in rad/m": (["1", "2"], [1.0, 1.0]),
    "q is a str of dtype <U9": ("table.csv", [1.0, 1.0]),
    "psd is a list of dtype complex128; .* real numbers in m⁴": ([1.0, 2.0], [1.0, 1j]),
    "psd is a MaskedArray": ([1.0, 2.0], np.ma.masked_array([1.0, 1.0], [0, 1])),
    "q is a NoneType": (None, [1.0, 1.0]),
}
BAND, TABLE = SelfAffineSpectrum(1.0, 0.5, 1.0, 1.0, 2.0), TabulatedSpectrum([1, 2], [1, 1])
SIZES = [
    ("rms_height = {} m", partial(SelfAffineSpectrum.from_rms_height, **GOOD)),
    ("rms_slope = {}", partial(SelfAffineSpectrum.from_rms_slope, **GOOD)),
    ("psd_at_roll_off = {} m⁴", lambda value: SelfAffineSpectrum(value, 0.5, 1.0, 1.0, 2.0)),
    *(("factor = {}", each.scaled) for each in (BAND, TABLE, BAND + BAND)),
    *(
        ("q_max = {} rad/m", lambda value, each=each: each.truncated(q_max=value))
        for each in (BAND, TABLE, BAND + BAND)
    ),
]


class Level:
    """C(q) of one value, whatever it is."""

    breaks = (2.3, 9.9)

    def __init__(self, value):
        self.value = value

    def __call__(self, q):
        return np.full_like(q, self.value)


def draw(spectrum=SPECTRUM, **options):
    return synthesize(spectrum, square(32), **{"rng": np.random.default_rng(0)} | options)


NO_RNG = (None, 5, np.random, np.random.RandomState(0))
NO_AMPLITUDES = ("Gaussian", "random", "", None, True)
OWN = [
    (r"q_min = 1 rad/m must be below q_max = 0\.5 rad/m", lambda: BAND.truncated(q_max=0.5)),
    (
        r"q_max = 0\.5 rad/m must exceed the first wavenumber 1 rad/m",
        lambda: TABLE.truncated(q_max=0.5),
    ),
    (
        r"q_max = 0\.5 rad/m must exceed the first wavenumber 1 rad/m",
        lambda: (BAND + TABLE).truncated(q_max=0.5),
    ),
    ("unsupported operand", lambda: BAND + 1.0),
    *(
        (r"spectrum = .* must give C\(q\) finite and ≥ 0", partial(draw, Level(value)))
        for value in (-1e-2, NAN, INF)
    ),
    *(
        (r"rng = .* must be a numpy Generator; .* np\.random\.default_rng", partial(draw, rng=rng))
        for rng in NO_RNG
    ),
    *(
        (r'amplitudes = .* must be "fixed" or "gaussian"', partial(draw, amplitudes=name))
        for name in NO_AMPLITUDES
    ),
]


@pytest.mark.parametrize(
    "build", [SelfAffineSpectrum.from_rms_height, SelfAffineSpectrum.from_rms_slope]
)
@pytest.mark.parametrize("words", SELF_AFFINE)
def test_self_affine_refuses_by_name_and_value(build, words):
    assert_refused(lambda: build(1e-6, **GOOD | SELF_AFFINE[words]), words)


@pytest.mark.parametrize("words", TABLES)
def test_tabulated_refuses_by_name_and_value(words):
    assert_refused(lambda: TabulatedSpectrum(*TABLES[words]), words)


@pytest.mark.parametrize(("words", "call"), SIZES)
def test_sizes_are_positive_and_finite(words, call):
    for value, limit in ((0.0, "positive"), (-1e-6, "positive"), (NAN, "finite"), (INF, "finite")):
        assert_refused(partial(call, value), f"{words.format(f'{value:.6g}')} must be {limit}")


@pytest.mark.parametrize(("words", "call"), OWN)
def test_surfaces_refuse_by_name_and_value(words, call):
    assert_refused(call, words)
