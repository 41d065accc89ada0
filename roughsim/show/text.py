"""Text for people: lines to the terminal, warnings and errors of one line, and making foreign text harmless.

Titles, paths and messages of other libraries may contain commands to the terminal; these characters are replaced.
"""

import codecs
import io
import logging
import os
import sys
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from shutil import get_terminal_size
from textwrap import wrap
from typing import Any, NoReturn

PIPED = 150  # columns of a pipe without the variable COLUMNS: it has no width, and no number is to be broken
_LONGEST = 1200  # characters of an error; a path of thousands is cut in its middle
_ASCII = {
    "±": "+/-", "×": "x", "µ": "u", "μ": "mu", "°": "deg", "²": "^2", "³": "^3", "⁴": "^4", "₀": "0", "₁": "1",
    "–": "-", "—": "-", "−": "-", "…": "...", "·": "*", "⟨": "<", "⟩": ">", "≤": "<=", "≥": ">=", "≈": "~", "≠": "!=",
    "→": "->", "∞": "inf", "∇": "grad ", "∫": "int ", "√": "sqrt", "′": "'", "’": "'", "“": '"', "”": '"',
    "α": "alpha", "γ": "gamma", "ζ": "zeta", "κ": "kappa", "λ": "lambda", "ν": "nu", "ξ": "xi", "π": "pi",
    "ρ": "rho", "σ": "sigma",
}  # fmt: skip


class SceneWarning(UserWarning):
    """A remark on a scene: a number beyond the model, or an assumption that is easily missed."""


def plain(text: object) -> str:
    """Return text on one line; control characters, such as commands to the terminal, become "?"."""
    return "".join(c if c.isprintable() else " " if c.isspace() else "?" for c in str(text))


def plain_lines(text: object) -> str:
    """Return text with each of its lines made `plain`."""
    return "\n".join(plain(line) for line in str(text).split("\n"))


def columns_of_terminal(piped: int = PIPED) -> int:
    """Return the variable COLUMNS, or the width of the terminal of the standard output, or `piped` without either."""
    return get_terminal_size((piped, 1)).columns


def wrapped(text: str, width: int) -> list[str]:
    """Return the lines of a text, broken between words."""
    lines = plain_lines(text).split("\n")
    whole: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
    return [part for line in lines for part in wrap(line, width, **whole) or [""]]


def print_in_any_language() -> None:
    """Let the output of this process replace letters that its encoding lacks, "+/-" for "±", instead of failing."""
    codecs.register_error("roughsim.ascii", _in_ascii)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="roughsim.ascii")


def _in_ascii(error: UnicodeError) -> tuple[str, int]:
    """Handle an encoding error: return the replacement of the letters, and the position after them."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(
        _ASCII.get(c, c.encode("ascii", "backslashreplace").decode()) for c in lacking
    ), error.end


def say(text: str) -> None:
    """Write lines to the standard output."""
    if sys.stdout is not None:  # None: it was closed before the start
        sys.stdout.write(f"{plain_lines(text)}\n")


def tell(text: str) -> None:
    """Write lines to the standard error, which a terminal breaks between words; nothing if it is closed."""
    if sys.stderr is not None:
        # a program that reads them, such as grep, wants whole lines
        width = columns_of_terminal() if sys.stderr.isatty() else sys.maxsize
        lines = wrapped(text, width)
        with suppress(OSError):
            sys.stderr.write("".join(f"{line}\n" for line in lines))
            sys.stderr.flush()


def note(text: str) -> None:
    """Log a line on slow work, at level INFO of the logger "roughsim"; the command line shows it."""
    logging.getLogger("roughsim").info(plain_lines(text))


class _ToStandardError(logging.Handler):
    """Writes what is logged to the standard error, as all lines of the command line."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write a line."""
        tell(f"roughsim: {record.getMessage()}")


def notes_are_shown() -> bool:
    """Return whether `note` has an effect."""
    return logging.getLogger("roughsim").isEnabledFor(logging.INFO)


def show_notes() -> None:
    """Show the lines of `note` from now on."""
    logger = logging.getLogger("roughsim")
    logger.setLevel(logging.INFO)
    logger.handlers = [_ToStandardError()]


def warn(text: object) -> None:
    """Write a warning to the standard error: one line, of the same form in every verb."""
    tell(f"roughsim: {marked([text])[0]}")


def marked(remarks: Iterable[object]) -> list[str]:
    """Return remarks, a line each, that begin with the word "warning"."""
    return [f"warning: {' '.join(str(remark).split())}" for remark in remarks]


def show_warnings_once() -> None:
    """Show Python's warnings as one line, each once: every picture of a report would repeat them.

    The remarks on a scene are left to the verbs, which print them below their tables.
    """
    before: set[str] = set()

    def show(message: Warning | str, *_: Any, **__: Any) -> None:
        if str(message) not in before:
            before.add(str(message))
            warn(message)

    warnings.showwarning = show
    warnings.simplefilter("ignore", SceneWarning)


def fail(message: str, code: int) -> NoReturn:
    """End the process with a line on the standard error and an exit code."""
    tell(f"roughsim: {message}")
    raise SystemExit(code)


@contextmanager
def errors_in_one_line(command: str) -> Iterator[None]:
    """Turn an exception inside into one line and a non-zero exit code; `command` is the typed command."""
    try:
        yield
    except BrokenPipeError:  # a closed pipe, as of `| head`
        raise SystemExit(1) from None
    except MemoryError as error:
        fail(
            f"out of memory ({_one_line(error)}); lower numerics.levels or the number of workers", 1
        )
    except ArithmeticError as error:
        kind = type(error).__name__
        fail(
            f"{command}: {kind} ({_one_line(error)}): a number is too large or too small to compute with",
            1,
        )
    except (ValueError, TypeError, OSError, RuntimeError, ImportError) as error:
        fail(_one_line(error), 1)
    except Exception as error:
        if not hasattr(
            error, "format_message"
        ):  # not an error of typer about the words of the command
            raise
        message = io.StringIO()
        error.show(file=message)  # type: ignore[attr-defined]
        tell(message.getvalue().rstrip("\n"))
        raise SystemExit(getattr(error, "exit_code", 2)) from None
    finally:
        # a stream that is full or closed goes to /dev/null: Python flushes it at its end, and would exit with 120
        for stream in (sys.stdout, sys.stderr):
            try:
                if stream is not None:
                    stream.flush()
            except OSError:
                with suppress(OSError):
                    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _one_line(error: BaseException) -> str:
    """Return the message of an error, or its name, on one line; a long one is cut in its middle."""
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST // 2]} … {text[-_LONGEST // 2 :]}"


def clock(seconds: float) -> str:
    """Return a time span in words: 12 s, 3 min 05 s, 28 h 03 min."""
    whole = round(seconds)
    if whole >= 3600:
        return f"{whole // 3600} h {whole % 3600 // 60:02d} min"
    return f"{whole // 60} min {whole % 60:02d} s" if whole >= 60 else f"{whole} s"
