"""Compiling is begun before all else that a run imports, and Python ends without a last look for garbage."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import roughsim as rs
from roughsim.contact.solver import ahead
from roughsim.ensemble.compiling import begin_compiling_for

ROOT = Path(__file__).parents[2]


def printed(code, *words):
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, words)], capture_output=True, text=True, cwd=ROOT, check=False
    )
    return done.stdout.split(), done.stderr


@pytest.mark.parametrize(("solver", "begun", "compiles"), [(None, False, 1), ("active_set", False, 1), (None, True, 0)])
def test_what_a_new_run_solves_with_is_compiled_first(monkeypatch, tmp_path, solver, begun, compiles):
    calls = []
    monkeypatch.setattr(ahead, "begin_compiling", lambda: calls.append(1))
    scene = rs.load_scene("demo")
    scene = replace(scene, numerics=replace(scene.numerics, solver=solver))
    begin_compiling_for(scene, tmp_path if begun else tmp_path / "new")
    assert len(calls) == compiles


def test_compiling_is_begun_before_plans_and_bars_are_imported(tmp_path):
    code = """
import sys
from roughsim.ensemble import compiling
def begin(scene, folder):
    print(*(name in sys.modules for name in ("roughsim.scene.files", "roughsim.planning.plan", "rich.progress")))
    raise SystemExit
compiling.begin_compiling_for = begin
from roughsim import cli
cli.main(["run", "demo", "-o", sys.argv[1]])
"""
    assert printed(code, tmp_path / "new")[0] == ["True", "False", "False"]


def test_the_command_ends_without_a_last_look_for_garbage():
    code = """
import atexit, gc
atexit.register(lambda: print(gc.get_freeze_count() > 1000))
from roughsim import cli
cli.main(["--version"])
"""
    assert printed(code)[0][-1] == "True"
