"""The table of stages: what it counts is there."""

import importlib.util
from pathlib import Path

import pytest

PATH = Path(__file__).parents[2] / "benchmarks" / "stages.py"


@pytest.mark.skipif(not PATH.exists(), reason="no checkout")
def test_every_function_whose_time_is_counted_exists():
    specification = importlib.util.spec_from_file_location("stages", PATH)
    stages = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(stages)
    of_stages = [place for places in stages.STAGES.values() for place in places]
    for place in (*of_stages, *stages.TRANSFORMS, *stages.ARITHMETIC):
        owner, name = stages.found(place)
        assert callable(getattr(owner, name)), place
