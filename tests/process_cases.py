"""Processes of tests: each ends with its test, and times are allowed for by the load of the machine."""

import subprocess
import time

_begun = []


def begin_process(words, **options):
    """Start a process, which is killed at the end of the test if it still runs."""
    _begun.append(subprocess.Popen([str(word) for word in words], **options))
    return _begun[-1]


def end_processes():
    """Kill what still runs; workers end with the process that started them."""
    while _begun:
        process = _begun.pop()
        process.kill()
        process.wait()


def slowness():
    """Wall time over CPU time of a short computation: 1 on an idle machine, more on a loaded one."""
    began, used = time.monotonic(), time.process_time()
    while time.process_time() < used + 0.1:
        pass
    return max((time.monotonic() - began) / 0.1, 1.0)
