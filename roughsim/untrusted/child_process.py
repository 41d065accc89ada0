"""A child process in which old and foreign files are opened: a library that hangs or crashes there ends only the child.

64 zeroed bytes in the header of an HDF5 file make the library loop in C, where no signal handler of Python runs. One
child serves all calls of a process; the first call starts it. It is no `multiprocessing` child, which would run the
caller's script again.
"""

from __future__ import annotations

import atexit
import faulthandler
import os
import pickle
import signal
import sys
from collections.abc import Callable
from subprocess import DEVNULL, PIPE, Popen
from threading import Lock
from typing import Any

_CRASHES = tuple(-getattr(signal, name) for name in ("SIGSEGV", "SIGABRT", "SIGBUS", "SIGFPE") if hasattr(signal, name))
_TIMED_OUT = -getattr(signal, "SIGPROF", -1)  # without SIGPROF, faulthandler ends the child with 1
_children: dict[int, Popen[bytes]] = {}  # by the pid of the parent: after a fork the copy must start its own
_lock = Lock()
_OPENER = "the process that opens files from elsewhere"


class ChildEndedError(Exception):
    """The child ended during a call: the library crashed, or used more CPU time than it had."""


def call_in_child(function: Callable[..., Any], *arguments: Any, seconds: float) -> Any:
    """Return ``function(*arguments)``, computed in the child; an exception it raises is raised here.

    Function, arguments and result are pickled, so the function belongs to a module. After `seconds` of CPU time the
    child is ended: ChildEndedError, as after a crash. OSError if no child can be started or another program ended it.
    """
    with _lock:
        child = _children.get(os.getpid())
        if child is None or child.poll() is not None:
            child = _started()
        assert child.stdin is not None
        assert child.stdout is not None
        try:
            pickle.dump((function, arguments, seconds), child.stdin)
            child.stdin.flush()
            result, error = pickle.load(child.stdout)
        except (EOFError, BrokenPipeError):
            code = _wait(child)
            if code == _TIMED_OUT:
                raise ChildEndedError(f"the library did not come back in {seconds:.0f} s of computing") from None
            if code in _CRASHES:
                raise ChildEndedError(f"the library crashed, signal {-code}") from None
            raise OSError(f"{_OPENER} was ended from outside ({code}); try again") from None
        except BaseException:  # after an interrupt, a late answer would be taken for that of the next call
            child.kill()
            _wait(child)
            raise
    if error is not None:
        raise error
    return result


def _started() -> Popen[bytes]:
    """A new child that has said that it is ready."""
    code = f"import sys; sys.path[:] = {sys.path!r}; from roughsim.untrusted.child_process import serve; serve()"
    child = _children[os.getpid()] = Popen([sys.executable, "-c", code], stdin=PIPE, stdout=PIPE, stderr=DEVNULL)
    assert child.stdout is not None
    if not child.stdout.read(1):
        raise OSError(f"{_OPENER} did not start; {sys.executable}: {_wait(child)}")
    return child


def _wait(child: Popen[bytes]) -> int:
    """Wait for a child that is ending, close its pipes, and return its exit code."""
    _children.pop(os.getpid(), None)
    child.communicate()  # drops what was not sent yet
    return child.returncode


@atexit.register
def end_child() -> None:
    """End the child of this process, if there is one."""
    child = _children.get(os.getpid())
    if child is not None:
        child.kill()
        _wait(child)


def serve() -> None:
    """Answer calls on the standard streams until they are closed. Runs in the child."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the parent too, and it ends the child
    # functions may print: what they print goes to the error stream, so that the answers stay apart from it
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    answers.write(b"+")
    answers.flush()
    while True:
        try:
            function, arguments, seconds = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        _limit_cpu_time(seconds)
        result, error = None, None
        try:
            result = function(*arguments)
        except Exception as raised:
            error = raised
        _limit_cpu_time(0.0)
        pickle.dump((result, error), answers)
        answers.flush()


def _limit_cpu_time(seconds: float) -> None:
    """Let the system end this process after `seconds` of CPU time (without POSIX: of time); 0 takes the limit off."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_PROF, seconds)
    elif seconds:
        faulthandler.dump_traceback_later(seconds, exit=True, file=sys.stderr)
    else:
        faulthandler.cancel_dump_traceback_later()
