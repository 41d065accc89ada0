"""Power spectra: arguments and tables that cannot be a spectrum are refused by name and value."""

import numpy as np
import pytest

from roughsim.surface.power_laws import SelfAffineSpectrum, TabulatedSpectrum

NAN, INF = float("nan"), float("inf")
GOOD = {"hurst": 0.8, "q_min": 1e3, "q_roll_off": 1e4, "q_max": 1e6, "roll_off_exponent": 1.5}
REFUSALS = [
    ({"hurst": -0.1}, ValueError, r"hurst = -0\.1 must lie in \[0, 1\]"),
    ({"hurst": 1.01}, ValueError, r"hurst = 1\.01 must lie in \[0, 1\]"),
    ({"hurst": NAN}, ValueError, "hurst = nan must be finite"),
    ({"hurst": "0.8"}, TypeError, "hurst = '0.8' must be one real number"),
    ({"hurst": [0.8]}, TypeError, r"hurst = \[0.8\] must be one real number"),
    ({"hurst": None}, TypeError, "hurst = None must be one real number"),
    ({"hurst": True}, TypeError, "hurst = True must be one real number"),
    (
        {"q_min": 1e6, "q_roll_off": 1e6},
        ValueError,
        r"q_min = 1e\+06 rad/m must be below q_max = 1e\+06 rad/m",
    ),
    ({"q_min": 2e6}, ValueError, r"q_min = 2e\+06 rad/m must be below q_max = 1e\+06 rad/m"),
    ({"q_min": 0}, ValueError, "q_min = 0 rad/m must be positive"),
    ({"q_min": -1e3}, ValueError, "q_min = -1000 rad/m must be positive"),
    ({"q_min": NAN}, ValueError, "q_min = nan rad/m must be finite"),
    ({"q_max": INF}, ValueError, "q_max = inf rad/m must be finite"),
    ({"q_max": "1e6"}, TypeError, "q_max = '1e6' must be one real number in rad/m"),
    (
        {"q_roll_off": 900.0},
        ValueError,
        "q_roll_off = 900 rad/m must lie between q_min = 1000 and q_max",
    ),
    (
        {"q_roll_off": 2e6},
        ValueError,
        r"q_roll_off = 2e\+06 rad/m must lie between q_min = 1000 and q_max",
    ),
    ({"q_roll_off": NAN}, ValueError, "q_roll_off = nan rad/m must be finite"),
    ({"q_roll_off": -1.0}, ValueError, "q_roll_off = -1 rad/m must be positive"),
    ({"roll_off_exponent": INF}, ValueError, "roll_off_exponent = inf must be finite"),
    ({"roll_off_exponent": 1j}, TypeError, "roll_off_exponent = 1j must be one real number"),
]


@pytest.mark.parametrize(("change", "error", "message"), REFUSALS)
@pytest.mark.parametrize(
    "build", [SelfAffineSpectrum.from_rms_height, SelfAffineSpectrum.from_rms_slope]
)
def test_an_argument_out_of_range_is_refused_by_name(build, change, error, message):
    with pytest.raises(error, match=message):
        build(1e-6, **{**GOOD, **change})


@pytest.mark.parametrize("value", [0.0, -1e-6, NAN, INF])
def test_a_roughness_that_is_none_is_refused(value):
    with pytest.raises(ValueError, match=r"rms_height = .* m must be (positive|finite)"):
        SelfAffineSpectrum.from_rms_height(value, **GOOD)
    with pytest.raises(ValueError, match=r"rms_slope = .* must be (positive|finite)"):
        SelfAffineSpectrum.from_rms_slope(value, **GOOD)
    spectrum = SelfAffineSpectrum(1.0, 0.5, 1.0, 1.0, 2.0)
    for each in (spectrum, TabulatedSpectrum([1.0, 2.0], [1.0, 1.0]), spectrum + spectrum):
        with pytest.raises(ValueError, match=r"factor = .* must be (positive|finite)"):
            each.scaled(value)
        with pytest.raises(ValueError, match=r"q_max = .* rad/m must be (positive|finite)"):
            each.truncated(q_max=value)
    with pytest.raises(ValueError, match=r"psd_at_roll_off = .* m⁴ must be (positive|finite)"):
        SelfAffineSpectrum(value, 0.5, 1.0, 1.0, 2.0)


def test_truncation_below_the_first_wavenumber_is_refused():
    with pytest.raises(ValueError, match=r"q_min = 1 rad/m must be below q_max = 0\.5 rad/m"):
        SelfAffineSpectrum(1.0, 0.5, 1.0, 1.0, 2.0).truncated(q_max=0.5)
    with pytest.raises(
        ValueError, match=r"q_max = 0\.5 rad/m must exceed the first wavenumber 1 rad/m"
    ):
        TabulatedSpectrum([1.0, 2.0], [1.0, 1.0]).truncated(q_max=0.5)


TABLES = [
    (
        [1.0, 3.0, 2.0],
        [1.0, 1.0, 1.0],
        ValueError,
        "q = 2 rad/m follows q = 3 rad/m and must exceed it",
    ),
    ([1.0, 1.0], [1.0, 1.0], ValueError, "q = 1 rad/m follows q = 1 rad/m and must exceed it"),
    ([1.0, 2.0], [1.0, 0.0], ValueError, "psd holds 0.0 m⁴"),
    ([1.0, 2.0], [1.0, -2.0], ValueError, "psd holds -2.0 m⁴"),
    ([1.0, 2.0], [NAN, 1.0], ValueError, "psd holds nan m⁴"),
    ([1.0, INF], [1.0, 1.0], ValueError, "q holds inf rad/m"),
    ([0.0, 2.0], [1.0, 1.0], ValueError, "q holds 0.0 rad/m"),
    ([1.0, 2.0], [1.0, 1.0, 1.0], ValueError, "q has 2 points but psd has 3"),
    ([1.0], [1.0], ValueError, r"q has shape \(1,\)"),
    ([[1.0, 2.0]], [[1.0, 1.0]], ValueError, r"q has shape \(1, 2\)"),
    (
        ["1", "2"],
        [1.0, 1.0],
        TypeError,
        r"q is a list of dtype <U1; a plain array of real numbers in rad/m is needed",
    ),
    ("table.csv", [1.0, 1.0], TypeError, "q is a str of dtype <U9; a plain array"),
    (
        [1.0, 2.0],
        [1.0, 1j],
        TypeError,
        "psd is a list of dtype complex128; a plain array of real numbers in m⁴ is needed",
    ),
    (
        [1.0, 2.0],
        np.ma.masked_array([1.0, 1.0], [0, 1]),
        TypeError,
        "psd is a MaskedArray of dtype float64; a plain array",
    ),
    (None, [1.0, 1.0], TypeError, "q is a NoneType of dtype object; a plain array"),
]


@pytest.mark.parametrize(("q", "psd", "error", "message"), TABLES)
def test_a_table_that_cannot_be_a_spectrum_is_refused(q, psd, error, message):
    with pytest.raises(error, match=message):
        TabulatedSpectrum(q, psd)
