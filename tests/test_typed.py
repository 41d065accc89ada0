"""Types of `theory` for type checkers: their keys are those of the functions, and scripts of users pass mypy."""

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

from theory import background, camera, flash, partition, typed

TYPED = {
    flash.flash_temperature: typed.Load,
    camera.seen_rms: camera._Seen,
    partition.moving_share: partition._Load,
    background.temperature: background._Flux,
}


@pytest.mark.parametrize("function", TYPED, ids=lambda one: one.__module__)
def test_typed_keys_are_those_of_the_function(function):
    keys = {
        key.name: key.default is key.empty
        for key in inspect.signature(function).parameters.values()
        if key.kind is key.KEYWORD_ONLY and key.name != "speed"
    }
    kind = TYPED[function]
    assert keys == {
        name: name in kind.__required_keys__
        for name in kind.__required_keys__ | kind.__optional_keys__
    }


@pytest.mark.slow
def test_scripts_of_users_pass_a_strict_type_checker(tmp_path):
    root = Path(__file__).parents[1]
    script = tmp_path / "script.py"
    script.write_text(
        "import numpy as np\n"
        "from numpy.typing import NDArray\n"
        "from theory import hertz\n"
        "one: float = hertz.max_temperature(peclet=3.0)\n"
        "many: NDArray[np.float64] = hertz.max_temperature(np.ones(3))\n"
        "wrong: float = hertz.max_temperature(np.ones(3))\n"
    )
    command = [sys.executable, "-m", "mypy", "--strict", script, root / "docs" / "examples"]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    errors = [line for line in done.stdout.splitlines() if "error:" in line]
    assert len(errors) == 1
    assert "script.py:6" in errors[0]
