"""Each script of experiments/ runs in its toy size."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SCRIPTS = sorted((ROOT / "experiments").glob("*.py"))


SEVERAL_SECONDS = ("accuracy_vs_cost", "budget", "flash_vs_speed", "validity")  # the toys of these


@pytest.mark.parametrize(
    "script",
    [pytest.param(path, marks=pytest.mark.slow if path.stem in SEVERAL_SECONDS else ()) for path in SCRIPTS],
    ids=lambda path: path.stem,
)
def test_the_toy_runs(script, tmp_path):
    words = [sys.executable, script, "--toy", "-o", tmp_path]
    done = subprocess.run(
        words, capture_output=True, text=True, check=False, env={"PYTHONPATH": str(ROOT), "PATH": ""}, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout
    assert list(tmp_path.glob("*.png"))
