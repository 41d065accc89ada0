"""Transforms in forked processes: threads of FFTW are gone there, and plans in the making are waited for."""

import os
import subprocess
import sys
import textwrap

import pytest

FORK = """
    import os, signal, sys, warnings
    import numpy as np
    import roughsim as rs
    from roughsim import fourier
    from roughsim.fourier import convolution
    rs.set_threads(2)
    field, grid = np.random.default_rng(0).standard_normal((512, 512)), rs.Grid((512, 512), (1.0, 1.0))

    def work():
        return [
            fourier.forward(field),
            convolution.convolve(field, np.ones((513, 1024)), (1024, 1024)),
            rs.solve_contact(field, grid, rs.Solid(1.0), nominal_pressure=100.0, tolerance=1e-2).pressure,
        ]

    parent = work()
    child = os.fork()
    if child == 0:
        signal.alarm(60)  # a hang ends here
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            same = [np.abs(a - b).max() <= 1e-12 * np.abs(a).max() for a, b in zip(parent, work())]
        told = any("forked from one with threads of FFTW" in str(w.message) for w in caught)
        os._exit(0 if all(same) and (told or "scipy" in fourier.backend()) else 1)
    sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.slow
def test_a_forked_process_transforms_on_though_the_threads_of_its_parent_are_gone():
    free = {name: value for name, value in os.environ.items() if name != "OMP_NUM_THREADS"}
    code = [sys.executable, "-W", "ignore", "-c", textwrap.dedent(FORK)]
    done = subprocess.run(code, capture_output=True, text=True, check=False, timeout=100, env=free)
    assert done.returncode == 0, done.stderr


FORK_WHILE_PLANNING = """
    import os, signal, sys, threading, time
    from roughsim import fourier
    from roughsim.fourier import plans
    begun, ready, kept = threading.Event(), threading.Event(), threading.local()

    def keep():
        if fourier.direct():
            kept.plans = plans.LinePlans(2, 8, (16, 16), float)  # destroyed in the child, with its thread
        ready.set()
        time.sleep(10)

    def plan():
        with plans.planning:
            begun.set()
            time.sleep(0.2)

    threading.Thread(target=keep, daemon=True).start()
    ready.wait()
    threading.Thread(target=plan, daemon=True).start()
    begun.wait()
    child = os.fork()
    if child == 0:
        thread = threading.Thread(target=fourier.Transform, args=((4, 6),), daemon=True)
        thread.start()
        thread.join(2)
        os._exit(thread.is_alive())
    ended, end = (0, 0), time.monotonic() + 4
    while ended[0] == 0 and time.monotonic() < end:
        time.sleep(0.01)
        ended = os.waitpid(child, os.WNOHANG)
    if ended[0] == 0:
        os.kill(child, signal.SIGKILL)
    thread = threading.Thread(target=fourier.Transform, args=((4, 6),), daemon=True)
    thread.start()
    thread.join(2)
    os._exit(thread.is_alive() or ended[0] == 0 or ended[1] != 0)
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_fork_waits_for_the_plan_another_thread_is_making():
    code = [sys.executable, "-W", "ignore", "-c", textwrap.dedent(FORK_WHILE_PLANNING)]
    done = subprocess.run(code, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
