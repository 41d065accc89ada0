"""Each script of experiments/ runs in its toy size."""

import re
import subprocess
import sys
from math import pi, sqrt
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


def test_means_of_two_rough_steels_are_over_the_last_half_of_their_slide(tmp_path):
    # half of the heat warms each body as 2q√(Dt/π)/κ, and the mean of √s from 8 to 16 mm is √16 mm · 2/3 (2 − 2^(−1/2))
    script = ROOT / "experiments" / "two_bodies.py"
    words, env = [sys.executable, script, "-o", tmp_path], {"PYTHONPATH": str(ROOT), "PATH": ""}
    text = subprocess.run(words, capture_output=True, text=True, check=True, env=env, timeout=300).stdout
    table = text[text.index("1.2GPa-f0.5-q1e+05-256-16mm") :]
    for speed in (1.0, 35.0):
        printed = re.search(rf"\n +{speed:g} m/s .*background ([0-9.]+) K", table)
        at_end = 2 * 0.5 * 0.11 * 90e6 * speed * sqrt(30 / (7900 * 500) * 16e-3 / speed / pi) / 30
        assert float(printed[1]) == pytest.approx(at_end * 2 / 3 * (2 - sqrt(0.5)), rel=0.01)
