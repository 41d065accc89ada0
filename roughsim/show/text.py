"""What is written to people: text that is not ours commands nothing, and an error is one line.

Titles, paths and messages of other libraries are printed as they are, without what a terminal would obey.
"""

import codecs
import io
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, NoReturn

LONGEST = 1200  # characters of an error; a path of thousands is cut in its middle
ASCII = {
    "±": "+/-", "×": "x", "µ": "u", "μ": "mu", "°": "deg", "²": "^2", "³": "^3", "⁴": "^4", "₀": "0", "₁": "1",
    "–": "-", "—": "-", "−": "-", "…": "...", "·": "*", "⟨": "<", "⟩": ">", "≤": "<=", "≥": ">=", "≈": "~", "≠": "!=",
    "→": "->", "∞": "inf", "∇": "grad ", "∫": "int ", "√": "sqrt", "′": "'", "’": "'", "“": '"', "”": '"',
    "α": "alpha", "γ": "gamma", "ζ": "zeta", "κ": "kappa", "λ": "lambda", "ν": "nu", "ξ": "xi", "π": "pi",
    "ρ": "rho", "σ": "sigma",
}  # fmt: skip


def plain(text: object) -> str:
    """Return text on one line; what does not print, such as the start of a command to the terminal, becomes "?"."""
    return "".join(c if c.isprintable() else " " if c.isspace() else "?" for c in str(text))


def plain_lines(text: object) -> str:
    """Return text with each of its lines made `plain`."""
    return "\n".join(plain(line) for line in str(text).split("\n"))


def print_in_any_language() -> None:
    """Let the streams of this process write what their encoding lacks in ASCII, "+/-" for "±", instead of failing."""
    codecs.register_error("roughsim.ascii", in_ascii)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="roughsim.ascii")


def in_ascii(error: UnicodeError) -> tuple[str, int]:
    """Return what stands for the letters that an encoding lacks, and where to go on: a handler of encoding errors."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(ASCII.get(c, c.encode("ascii", "backslashreplace").decode()) for c in lacking), error.end


def say(text: str) -> None:
    """Write lines to the standard output."""
    if sys.stdout is not None:  # None: it was closed before the start
        sys.stdout.write(f"{plain_lines(text)}\n")


def tell(text: str) -> None:
    """Write lines to the standard error, where it takes any."""
    if sys.stderr is not None:
        with suppress(OSError):
            sys.stderr.write(f"{plain_lines(text)}\n")
            sys.stderr.flush()


def warn(text: object) -> None:
    """Write a warning to the standard error: one line, of the same form in every verb."""
    tell(f"roughsim: warning: {' '.join(str(text).split())}")


def show_warnings_once() -> None:
    """Show Python's warnings without the place in the code, each once: every picture of a report warns again."""
    before: set[str] = set()

    def show(message: Warning | str, *_: Any, **__: Any) -> None:
        if str(message) not in before:
            before.add(str(message))
            warn(message)

    warnings.showwarning = show


def fail(message: str, code: int) -> NoReturn:
    """End with a line and an exit code."""
    tell(f"roughsim: {message}")
    raise SystemExit(code)


@contextmanager
def errors_in_one_line(asked: str) -> Iterator[None]:
    """End with one line and a non-zero exit code if what is done inside fails; `asked` are the words of the command."""
    try:
        yield
    except BrokenPipeError:  # nobody reads on: `| head`
        raise SystemExit(1) from None
    except MemoryError as error:
        fail(f"out of memory ({one_line(error)}); lower numerics.levels or the number of workers", 1)
    except ArithmeticError as error:
        kind = type(error).__name__
        fail(f"{asked}: {kind} ({one_line(error)}): a number of it is too large or too small to compute with", 1)
    except (ValueError, TypeError, OSError, RuntimeError, ImportError) as error:
        fail(one_line(error), 1)
    except Exception as error:
        if not hasattr(error, "format_message"):  # what the command line says of words that it does not know
            raise
        message = io.StringIO()
        error.show(file=message)  # type: ignore[attr-defined]
        tell(message.getvalue().rstrip("\n"))
        raise SystemExit(getattr(error, "exit_code", 2)) from None
    finally:
        # full or closed streams are led to nowhere: Python writes what they hold at its end, and would end with 120
        for stream in (sys.stdout, sys.stderr):
            try:
                if stream is not None:
                    stream.flush()
            except OSError:
                with suppress(OSError):
                    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def one_line(error: BaseException) -> str:
    """Return the message of an error, or its name, on one line; a long one is cut in its middle."""
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]} … {text[-LONGEST // 2 :]}"
