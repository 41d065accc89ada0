"""Each script of experiments/ runs in its toy size."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SCRIPTS = sorted(path for path in (ROOT / "experiments").glob("*.py") if path.stem != "script")  # what they share
QUICK = ("uncertainty",)  # the toys of the others take seconds


@pytest.mark.parametrize(
    "script",
    [pytest.param(path, marks=() if path.stem in QUICK else pytest.mark.slow) for path in SCRIPTS],
    ids=lambda path: path.stem,
)
def test_the_toy_runs(script, tmp_path):
    if script.stem == "scans":
        pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    words = [sys.executable, script, "--toy", "-o", tmp_path]
    done = subprocess.run(
        words, capture_output=True, text=True, check=False, env={"PYTHONPATH": str(ROOT), "PATH": ""}, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout
    assert list(tmp_path.glob("*.png"))
