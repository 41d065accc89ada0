"""Compiling ahead: what a machine without compiled kernels does before its first solve."""

import gc
import os
import subprocess
import sys
import textwrap
from functools import cache
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

import roughsim as rs
from roughsim._kernels import found_compiled, never_compiled
from roughsim.contact.solver import ahead
from roughsim.machine import Limit
from roughsim.show import text


class Helper:
    """Stands in for the second process."""

    started: ClassVar[list] = []

    def __init__(self, words, **_):
        self.started.append(words)

    def wait(self):
        self.started.append("waited")


@pytest.fixture
def helper(monkeypatch):
    monkeypatch.setattr(Helper, "started", [])
    monkeypatch.setattr(ahead.subprocess, "Popen", Helper)
    monkeypatch.setattr(text, "notes_are_shown", True)
    monkeypatch.setattr(ahead, "usable_cores", lambda: Limit(2, "here"))
    monkeypatch.setattr(ahead, "second_process", cache(ahead.second_process.__wrapped__))
    return Helper


def test_where_kernels_are_in_the_cache_nothing_is_compiled_ahead(helper, monkeypatch, capsys):
    monkeypatch.setattr(ahead, "never_compiled", lambda kernel: False)  # also where the cache of the tests is empty
    monkeypatch.setattr(ahead, "found_compiled", lambda kernel: True)
    ahead.compile_ahead.__wrapped__()
    assert helper.started == []
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("cores", [1, 2])
def test_without_compiled_kernels_a_second_core_helps_and_one_line_says_what_takes_long(
    helper, monkeypatch, capsys, cores
):
    monkeypatch.setattr(ahead, "found_compiled", lambda kernel: False)
    monkeypatch.setattr(ahead, "usable_cores", lambda: Limit(cores, "here"))
    ahead.compile_ahead.__wrapped__()
    assert [words if words == "waited" else words[0] for words in helper.started] == (
        [sys.executable, "waited"] if cores == 2 else []
    )
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("interpreter", [None, "", "no/python"])
def test_where_no_process_can_be_started_this_one_compiles_all(monkeypatch, interpreter):
    # a program that embeds Python may name none, and a full table of processes refuses
    monkeypatch.setattr(ahead, "usable_cores", lambda: Limit(2, "here"))
    monkeypatch.setattr(ahead, "second_process", cache(ahead.second_process.__wrapped__))
    monkeypatch.setattr(ahead, "found_compiled", lambda kernel: False)
    monkeypatch.setattr(sys, "executable", interpreter)
    halves = []
    monkeypatch.setattr(ahead, "compile_half", lambda: halves.append(1))
    ahead.compile_ahead.__wrapped__()
    assert halves == [1]


def test_where_nothing_can_be_kept_no_second_process_is_started(helper, monkeypatch, capsys):
    kernel = SimpleNamespace(__name__="contact_sum", stats=SimpleNamespace(cache_path=None, cache_hits={}))
    assert found_compiled(kernel)
    kernel.stats.cache_path = "somewhere"
    assert not found_compiled(kernel)
    kernel.stats.cache_hits = {"types": 1}
    assert found_compiled(kernel)
    monkeypatch.setattr(ahead, "never_compiled", lambda kernel: False)
    monkeypatch.setattr(ahead, "found_compiled", lambda _: found_compiled(SimpleNamespace(stats=unkept)))
    unkept = SimpleNamespace(cache_path=None, cache_hits={})
    ahead.compile_ahead.__wrapped__()
    assert helper.started == []
    assert capsys.readouterr().err == ""


def test_a_kernel_was_never_compiled_where_its_cache_holds_nothing_of_it(tmp_path):
    kernel = SimpleNamespace(__name__="contact_sum", stats=SimpleNamespace(cache_path=str(tmp_path / "none")))
    assert never_compiled(kernel)
    kernel.stats.cache_path = str(tmp_path)
    (tmp_path / "active_set.other_contact_sum-1.py311.nbi").touch()
    assert never_compiled(kernel)
    (tmp_path / "active_set.contact_sum-43.py311.nbi").touch()
    assert not never_compiled(kernel)
    kernel.stats.cache_path = None  # nothing can be kept
    assert not never_compiled(kernel)
    assert not never_compiled(lambda: None)  # kernels are not compiled at all


def test_garbage_is_collected_again_after_compiling():
    for enabled in (True, False):
        (gc.enable if enabled else gc.disable)()
        try:
            with ahead.garbage_kept():
                assert not gc.isenabled()
            assert gc.isenabled() == enabled
        finally:
            gc.enable()


def test_a_program_that_calls_roughsim_is_told_nothing(helper, monkeypatch, capsys):
    monkeypatch.setattr(ahead, "found_compiled", lambda kernel: False)
    monkeypatch.setattr(text, "notes_are_shown", False)
    ahead.compile_ahead.__wrapped__()
    assert capsys.readouterr() == ("", "")


def test_a_tiny_problem_of_either_half_is_no_part_of_later_solves():
    grid, solid = rs.Grid((16, 16), (1.0, 1.0)), rs.Solid(1.0)
    heights = np.random.default_rng(5).normal(size=grid.shape)
    before = rs.solve_contact(heights, grid, solid, nominal_pressure=0.1).pressure
    ahead.compile_half()
    ahead.compile_other_half()
    assert np.array_equal(rs.solve_contact(heights, grid, solid, nominal_pressure=0.1).pressure, before)


@pytest.mark.slow
def test_after_both_halves_a_solve_on_several_grids_compiles_nothing(tmp_path):
    code = """
        import numba.core.event as event, numpy as np, roughsim as rs
        from roughsim.contact.active_set import solve_contact
        from roughsim.contact.solver import ahead
        ahead.compile_ahead()
        class Compiled(event.Listener):
            def on_start(self, event):
                print("compiled:", event.data["dispatcher"].py_func.__name__)
            def on_end(self, event):
                pass
        event.register("numba:compile", Compiled())
        grid = rs.Grid((256, 256), (1e-3, 1e-3))
        spectrum = rs.SelfAffineSpectrum.from_rms_slope(0.1, hurst=0.8, q_min=6e3, q_roll_off=2e4, q_max=2e5)
        heights = rs.synthesize(spectrum, grid, np.random.default_rng(1))
        for cap in (np.inf, 5e8):
            contact = rs.solve_contact(heights, grid, rs.Solid(2e11, cap), nominal_pressure=1e7, tolerance=1e-7)
            rs.measure(contact, grid, rs.HeatSource([1.0], 0.1, 30.0, 1e-5))
    """
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    words = [sys.executable, "-c", textwrap.dedent(code)]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
