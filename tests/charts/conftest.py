"""Runs and figures that the tests of several charts share."""

from dataclasses import replace

import pytest

import roughsim as rs


@pytest.fixture(scope="session")
def full_run(full_scene, tmp_path_factory):
    """Full contact in an oblong cell: nothing to outline, nothing to enlarge."""
    numerics = replace(
        full_scene.numerics,
        lengths=(4e-3, 2e-3),
        levels=({"column": "elastic", "shape": [192, 96], "q_max": 1e5},),
        tolerance=1e-6,
    )
    scene = replace(full_scene, title="costs $5 & more $", numerics=numerics)
    return rs.run(scene, tmp_path_factory.mktemp("runs") / "full", max_realizations=2)
