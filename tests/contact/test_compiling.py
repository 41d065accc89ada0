"""The first command on a machine compiles the solver, and prints one line about it."""

import os
import subprocess
import sys

import pytest


@pytest.mark.slow
@pytest.mark.parametrize("workers", ["1", "2"])
def test_the_first_run_on_a_machine_prints_one_line_on_compilation_and_later_runs_none(
    tmp_path, workers
):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    counts = []
    for folder in ("first", "second"):
        words = [
            sys.executable,
            "-m",
            "roughsim",
            "run",
            "demo",
            "-o",
            str(tmp_path / folder),
            "--max",
            "2",
        ]
        done = subprocess.run(
            [*words, "--workers", workers],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        )
        counts.append(done.stderr.count("compiling the contact solver"))
    assert counts == [1, 0]
