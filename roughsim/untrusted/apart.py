"""A process of its own in which files of others are opened: a library that spins or crashes on one ends only it.

64 zeroed bytes in the header of an HDF5 file make the library spin in C, where no signal handler of Python runs. One
such process serves all files of the process that asks; it is started with the first of them. It is no child of
`multiprocessing`, which would run the script of the caller again.
"""

from __future__ import annotations

import atexit
import faulthandler
import os
import pickle
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from subprocess import DEVNULL, PIPE, Popen
from threading import Lock
from typing import Any

_CRASHES = tuple(-getattr(signal, name) for name in ("SIGSEGV", "SIGABRT", "SIGBUS", "SIGFPE") if hasattr(signal, name))
_TIMED_OUT = -getattr(signal, "SIGPROF", -1)  # elsewhere faulthandler ends it with 1
_helpers: dict[int, Popen[bytes]] = {}  # of each process its own: a fork must not use that of its parent
_lock = Lock()


class EndedError(Exception):
    """The process ended over a call: the library crashed, or did not come back in the time it had."""


def call_apart(function: Callable[..., Any], *arguments: Any, seconds: float) -> Any:
    """Return ``function(*arguments)`` as another process computes it.

    Parameters
    ----------
    function : callable
        Of a module; it, the arguments, the result and what it raises are pickled.
    *arguments : object
        What it is called with.
    seconds : float
        CPU time after which the process is ended.

    Raises
    ------
    EndedError
        If it took longer, or crashed; what `function` raises is raised here.
    OSError
        If there is no such process to be had, or it was ended from outside.
    """
    with _lock:
        helper = _helper()
        assert helper.stdin is not None
        assert helper.stdout is not None
        try:
            pickle.dump((function, arguments, seconds), helper.stdin)
            helper.stdin.flush()
            result, error = pickle.load(helper.stdout)
        except (EOFError, BrokenPipeError):
            raise _how(_end(helper), seconds) from None
        except BaseException:  # an interrupt: what it would answer now is no answer to the next call
            helper.kill()
            _end(helper)
            raise
    if error is not None:
        raise error
    return result


def _helper() -> Popen[bytes]:
    """The process that serves this one, started if need be, and ready."""
    helper = _helpers.get(os.getpid())
    if helper is not None and helper.poll() is None:
        return helper
    code = f"import sys; sys.path[:] = {sys.path!r}; from roughsim.untrusted.apart import serve; serve()"
    helper = _helpers[os.getpid()] = Popen([sys.executable, "-c", code], stdin=PIPE, stdout=PIPE, stderr=DEVNULL)
    assert helper.stdout is not None
    if not helper.stdout.read(1):
        raise OSError(f"the process that opens files from elsewhere did not start; {sys.executable}: {_end(helper)}")
    return helper


def _end(helper: Popen[bytes]) -> int:
    """Wait for a process that is ending, and return how it ended."""
    _helpers.pop(os.getpid(), None)
    code = helper.wait()
    for pipe in (helper.stdin, helper.stdout):
        with suppress(OSError):  # what was not sent yet cannot be sent now
            assert pipe is not None
            pipe.close()
    return code


def _how(code: int, seconds: float) -> Exception:
    """The error that says how a process ended over a call."""
    if code == _TIMED_OUT:
        return EndedError(f"the library did not come back in {seconds:.0f} s of computing")
    if code in _CRASHES:
        return EndedError(f"the library crashed, signal {-code}")
    return OSError(f"the process that opens files from elsewhere was ended from outside ({code}); try again")


@atexit.register
def _leave() -> None:
    helper = _helpers.get(os.getpid())
    if helper is not None:
        helper.kill()
        _end(helper)


def serve() -> None:
    """Answer calls on the standard streams until they are closed; of what calls print, nothing gets between."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that asks ends this one
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    answers.write(b"+")
    answers.flush()
    while True:
        try:
            function, arguments, seconds = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        _limit(seconds)
        answer: tuple[Any, Exception | None]
        try:
            answer = function(*arguments), None
        except Exception as error:
            answer = None, error
        _limit(0.0)
        pickle.dump(answer, answers)
        answers.flush()


def _limit(seconds: float) -> None:
    """Let the system end this process after `seconds` of its CPU time (elsewhere than on POSIX: of time); 0: never."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_PROF, seconds)
    elif seconds:
        faulthandler.dump_traceback_later(seconds, exit=True, file=sys.stderr)
    else:
        faulthandler.cancel_dump_traceback_later()
