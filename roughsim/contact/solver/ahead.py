"""Compiling ahead: on a machine where no kernel of the solver is compiled yet, two processes share the work.

Otherwise one process would compile each kernel as its first solve comes to it. What this module does not reach is
compiled in that way.
"""

import gc
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import numpy as np

from roughsim._kernels import active_set, found_compiled, never_compiled
from roughsim._kernels.gathering import POWERS, moments_of_columns
from roughsim._kernels.interpolation import refine, tables
from roughsim.contact.solver.operators import Extension, half_space
from roughsim.contact.solver.problem import ScaledProblem, highest_wavenumber, pressed_at
from roughsim.contact.solver.state import State
from roughsim.fourier.power import gathered_power
from roughsim.grid import Field, Grid
from roughsim.machine import usable_cores
from roughsim.show.text import note

GRID = Grid((16, 16), (1.0, 1.0))


@cache
def compile_ahead() -> None:
    """Compile the kernels of the solver where none is in the cache: here, and in a second process if there is a core.

    A process asks once. Where kernels are in the cache this loads the smallest of them. Where nothing can be kept a
    second process would help nobody.
    """
    if not never_compiled(active_set.contact_sum):
        active_set.contact_sum(0, 1, np.ones(1), np.ones(1))
        if found_compiled(active_set.contact_sum):
            return
    second = second_process()
    compile_half()
    if second is not None:
        second.wait()  # what it failed to compile is compiled when it is needed


@cache
def second_process() -> "subprocess.Popen[bytes] | None":
    """Say what takes long, start the process that compiles the other half, and return it.

    None if this process may use one core, or no process can be started: then this one compiles all.
    """
    note("compiling the contact solver, once on this machine: some seconds")
    if usable_cores().amount < 2 or not sys.executable:
        return None
    # with the modules of this process, and without its script; to take all apart at the end would take a tenth of a
    # second
    names = "import compile_other_half as go; go(); os._exit(0)"
    code = f"import os, sys; sys.path[:] = sys.argv[1:]; from {__name__} {names}"
    quiet = subprocess.DEVNULL
    try:
        return subprocess.Popen([sys.executable, "-c", code, *sys.path], stdin=quiet, stdout=quiet, stderr=quiet)
    except OSError:
        return None


@contextmanager
def garbage_kept() -> Iterator[None]:
    """Collect no garbage meanwhile: a compiler makes hardly any, and to look for it takes a tenth of the time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


@garbage_kept()
def compile_other_half() -> None:
    """Compile the kernels of the preconditioner, of moments, and those that look at the heights: about half of all."""
    extension, free, pressure = Extension(GRID, np.float32), np.ones(GRID.shape, np.int8), np.ones(GRID.shape)
    field, step, response = (np.zeros(GRID.shape, np.float32) for _ in range(3))
    extension.extend(free, field)
    extension.transpose(free, field, step, response)
    extension.gather_load(free, field, pressure, 1.0, step)
    spectrum = half_space(GRID, np.float64).complex_spectrum
    spectrum[...] = 0.0
    highest_wavenumber(GRID, spectrum)
    pressed_at(0, GRID, spectrum)
    gathered_power(spectrum.T, GRID.multiplicity, np.zeros(GRID.half_shape[1] ** 2, np.intp), 1)
    moments_of_columns(np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((POWERS, 1)))


@garbage_kept()
def compile_half() -> None:
    """Compile the kernels of all else in a solve."""
    state = State(ScaledProblem(heights(), 0.0, 1.0, GRID, 0.01, 1.0, 1.0))
    spectrum = half_space(GRID, np.float64)
    spectrum.forward(heights())
    spectrum.inverse(state.gap)
    state.pressure[...] = state.problem.load
    for kind in (np.float64, np.float32):
        state.refresh(kind)
    state.begin()
    state.assess(1.0)
    state.find_offset()
    state.propose(0.0, 0.0)
    state.respond()
    state.move(0.0)
    state.range_shrank()
    state.balance(1e-12)
    places, buffers = tables(GRID.shape, GRID.shape, state.kind), np.empty((2, GRID.shape[1]), state.kind)
    refine(0, 1, *places, state.field, 1.0, state.pressure, state.free, *buffers)
    p, gap = state.flat[:2]
    active_set.to_si(0, 1, p, gap, heights().ravel(), (1.0, 1.0, 1.0), (np.inf, np.inf))


def heights() -> Field:
    """Return a wave."""
    return np.cos(2 * np.pi * np.arange(GRID.points) / GRID.shape[0]).reshape(GRID.shape)
