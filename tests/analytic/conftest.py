import json
from pathlib import Path

import pytest
from power_law import PowerLaw

_REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "theory.json").read_text())


@pytest.fixture(scope="session")
def reference():
    return _REFERENCE


@pytest.fixture(scope="session", params=["steel_like", "light_load"])
def case(request):
    """One whole elastic case: its spectrum, its physics, and the numbers recomputed by make_theory.py."""
    return describe(_REFERENCE["cases"][request.param])


@pytest.fixture(scope="session")
def six_decades():
    return describe(_REFERENCE["six_decades"])


@pytest.fixture(scope="session")
def far():
    return describe(_REFERENCE["far"])


@pytest.fixture(scope="session")
def steel():
    return describe(_REFERENCE["steel"])


def describe(entry):
    given = entry["given"]
    contact = {
        "effective_modulus": given["modulus"],
        "nominal_pressure": given["pressure"],
        "gamma": given["gamma"],
    }
    body = {"conductivity": given["conductivity"], "diffusivity": given["diffusivity"]}
    return {
        **entry,
        "spectrum": PowerLaw(given["psd"], tuple(given["q"]), given["hurst"], given["low"]),
        "contact": contact,
        "body": body,
        "sliding": {**contact, **body, "friction_coefficient": given["friction"]},
    }
