"""Names and units near to what people write, and hints for common words that are no keys of a scene."""

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from decimal import Decimal
from difflib import get_close_matches
from typing import Any

_UNITS = (
    "nm, um, µm, mm, cm, m, mm/s, m/s, km/h, us, ms, s, K, eV, J, Pa, kPa, MPa, GPa, N/mm^2, g/cm^3, kg/m^3, 1/m, 1/mm,"
    " 1/um, rad/m, 1/s, deg, rad, %, J/(kg K), kJ/(kg K), J/(g K), W/(m K), W/(cm K)"
)
_MEANT = {"mu": "um", "mu m": "um", "µ": "um", "μ": "um", "u": "um", "ms-1": "m/s", "ms^-1": "m/s"}
_JOULE_PER_EV, _PER_MOLE = Decimal("1.602176634e-19"), Decimal("6.02214076e23")
_SYMBOLS = {
    "rms_height": ("h_rms", "Rq", "Sq"),
    "rms_slope": ("xi", "Rdq", "Sdq"),
    "hurst": ("H",),
    "q_min": ("q0", "q_0"),
    "q_roll_off": ("q_r", "qr"),
    "q_max": ("q1", "q_1"),
    "youngs_modulus": ("E",),
    "poisson_ratio": ("nu",),
    "penetration_hardness": ("hardness", "sigma_P"),
    "conductivity": ("kappa",),
    "density": ("rho",),
    "heat_capacity": ("specific_heat", "C_p", "c_p", "cp"),
    "nominal_pressure": ("sigma_0", "sigma0"),
    "friction_coefficient": ("friction", "mu"),
    "speed": ("velocity", "v"),
    "duration": ("time",),
}
_MEAN_HEIGHT = "for Gaussian heights the rms_height is 1.25 Ra; give that"

OTHER_NAMES = {
    symbol: f'did you mean "{key}"?' for key, symbols in _SYMBOLS.items() for symbol in symbols
} | {
    "diffusivity": "it is conductivity/(density·heat_capacity); give these three",
    "thermal_diffusivity": "it is conductivity/(density·heat_capacity); give these three",
    "effusivity": "it is √(conductivity·density·heat_capacity); give these three",
    "effective_modulus": "it follows from youngs_modulus and poisson_ratio of both bodies; give these",
    "shear_modulus": "it is youngs_modulus/(2 (1 + poisson_ratio)); give these two",
    "R_a": _MEAN_HEIGHT,
    "Ra": _MEAN_HEIGHT,
    "load": "the nominal_pressure is the load over the nominal area; give that",
    "wavelength": "waves are given as q = 2π/wavelength: the longest by q_min, the shortest by q_max",
}


def nearest(word: str, names: Iterable[str]) -> str | None:
    """Return the name closest to a misspelt word, ignoring case; None if none is close."""
    by_lower = {name.lower(): name for name in names}
    near = get_close_matches(word.lower(), by_lower, n=1, cutoff=0.6)
    return by_lower[near[0]] if near else None


def suggestion(number: str, name: str, unit: str, units: Any) -> str:
    """Return ``; did you mean "..."?`` for a unit that cannot be read as `unit`, an SI unit; "" without a spelling.

    `units` is pint's registry.
    """
    if name[:1].isdigit():  # of a number with blanks between its thousands
        return "; write the number without blanks"
    if unit == "Pa" and re.match(r"HV|HB|HRC", name):
        return "; 100 HV or HB are about 1 GPa, a table has those of HRC"
    for spelling in _spellings(name):
        with suppress(Exception):  # pint fails in a dozen ways
            found = units.parse_units(spelling)
            if spelling != name and found.is_compatible_with(unit):
                return f'; did you mean "{number} {spelling}"?'
            if unit == "J" and found.is_compatible_with("J/mol"):
                joule = units.Quantity(Decimal(number), found).to("J/mol").magnitude / _PER_MOLE
                return f'; this is per mole: of one molecule it is "{joule / _JOULE_PER_EV:.5g} eV"'
    return ""


def _spellings(name: str) -> Iterator[str]:
    """Yield spellings that a unit may stand for: powers, Celsius, a joint denominator, the nearest common one."""
    powers = re.sub(r"(?<=[^\W\d_])(-?[1-9])", r"^\1", name)
    yield _MEANT.get(name, powers)
    yield powers
    yield name.lower()
    yield re.sub(r"^(deg\.? ?|° ?)?C$", "degC", name)
    yield re.sub(r"/\s*([^()/]*[^()/ ][ *·⋅][^()/]*)$", r"/(\1)", powers)
    common = nearest(powers, _UNITS.split(", "))
    if common:
        yield common


def with_decimal_point(text: str) -> str:
    """Return ``; the decimal sign is a point: ...`` for a number with a decimal comma, else ""."""
    match = re.fullmatch(r"\s*([-+]?\d+),(\d+(?:[eE][-+]?\d+)?)(.*)", text)
    return (
        f"; the decimal sign is a point: {match[1]}.{match[2]}{match[3].rstrip()}" if match else ""
    )
