"""Memory that arrays have left: a run keeps it for the next ones, and gives it back at its end."""

import resource
import subprocess
import sys

import numpy as np
import pytest

from roughsim.ensemble import memory
from roughsim.ensemble.workforce import ThisProcess, Workforce


@pytest.fixture
def library(monkeypatch):
    """A C library that notes what it is told."""

    class Library:
        def __init__(self):
            self.told = []

        def mallopt(self, parameter, value):
            self.told.append((parameter, value))

        def malloc_trim(self, left):
            self.told.append(("trim", left))

    told = Library()
    monkeypatch.setattr(memory.ctypes, "CDLL", lambda name: told)
    monkeypatch.setattr(memory, "_kept", memory.Kept())
    return told


def test_who_keeps_much_does_not_keep_less_for_a_call_of_others(library):
    memory.keep_freed_memory()
    memory.keep_freed_memory(memory.MUCH)
    assert library.told[-2:] == [(memory.FREE, memory.MUCH), (memory.PAGES, memory.MUCH // 3)]
    count = len(library.told)
    memory.keep_freed_memory()
    assert len(library.told) == count


def test_a_run_in_this_process_keeps_much_and_gives_it_back(library):
    with Workforce(1, None) as force:
        force.pool()
        assert library.told[0] == (memory.FREE, memory.MUCH)
    assert library.told[-1] == ("trim", 0)
    assert (memory.FREE, memory.SOME) in library.told
    with Workforce(1, None) as force:  # and the next one keeps it again
        force.pool()
    assert library.told.count((memory.FREE, memory.MUCH)) == 2


def test_memory_of_a_process_that_is_not_ours_alone_stays_as_it_is(library):
    with Workforce(1, ThisProcess()) as force:
        force.pool()
    assert library.told == []


@pytest.mark.parametrize("failure", [OSError, TypeError])
def test_a_process_with_another_c_library_keeps_its_own_ways(monkeypatch, failure):
    def without_library(name):
        raise failure

    monkeypatch.setattr(memory, "_kept", memory.Kept())
    for library in (without_library, lambda name: object()):
        monkeypatch.setattr(memory.ctypes, "CDLL", library)
        memory.keep_freed_memory(memory.MUCH)
        memory.give_memory_back()


CODE = """
import resource, numpy as np
from roughsim.ensemble.memory import MUCH, give_memory_back, keep_freed_memory

def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(20):
        np.ones(6 << 20)
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

def resident():
    return int(open("/proc/self/statm").read().split()[1])

first, count = resident(), faults()
keep_freed_memory(MUCH)
faults()
kept, held = faults(), resident()
give_memory_back()
print(count, kept, held - first, resident() - first)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="counts pages as Linux does")
def test_arrays_of_50_megabytes_take_no_new_pages_and_leave_none():
    said = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=True).stdout
    asked, kept, held, left = (int(word) for word in said.split())
    if asked < 100:
        pytest.skip("this C library keeps memory by itself")
    pages = (6 << 20) * np.float64().nbytes // resource.getpagesize()
    assert kept < 0.1 * asked
    assert held > 0.9 * pages
    assert left < 0.1 * pages
