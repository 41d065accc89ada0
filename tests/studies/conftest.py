"""A small scene, and a finished study of it."""

from dataclasses import replace

import pytest
from study_cases import VARY

import roughsim as rs


@pytest.fixture(scope="session")
def small(capped_scene):
    levels = [
        {"column": "capped", "shape": [32, 32], "q_max": 3e4},
        {"column": "capped", "shape": [64, 64], "q_max": 6e4},
    ]
    numerics = replace(capped_scene.numerics, levels=levels, keep_fields=None)
    ensemble = replace(capped_scene.ensemble, until={"flash_temperature": 0.5}, max_realizations=16)
    return replace(capped_scene, numerics=numerics, ensemble=ensemble)


@pytest.fixture(scope="session")
def done(small, tmp_path_factory):
    """A finished study; tests only read it."""
    return rs.study(small, vary=VARY, folder=tmp_path_factory.mktemp("studies") / "loads")
