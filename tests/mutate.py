"""Plant single-character errors in formulas and kernels, one at a time, and see whether a test notices.

    python tests/mutate.py [--only WORD ...] [--seed S] [--each N] [--list]

Each error is planted in a private copy of the sources, and tests are run on it until one fails: those that run its
line, the ones with the fewest lines first, then all test files of its room. Which tests run a line is read from
build/coverage, which tests/coverage.sh makes with `COVERAGE_FILE=build/coverage`; it is made again when a source or a
test is newer. Where the process of the tests does not run the line (child processes, compiled kernels), the tests that
run any line of the module stand in. The test files of the room see errors in results that fixtures and caches keep.

A digit grows by one, 1e-9 becomes 1e+9, + and − or * and / change places, also before =, < becomes > (or loses its =),
== becomes !=, ** becomes *, `and` becomes `or`, `not` vanishes. What stands in EQUAL is no error: the result is the
same, only the way to it differs. Not collected by pytest: it takes half an hour.
"""

from __future__ import annotations

import argparse
import ast
import io
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
import tokenize
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
COVERAGE = ROOT / "build" / "coverage"
# beginnings of paths without errors to plant, and why
LEFT_OUT = {
    "roughsim/charts/": "sizes, places and colours of what is drawn",
    "roughsim/explore/layout.py": "sizes and places of a page",
}
CLOSEST = 60  # tests that are tried first
# what looks at the clock or starts processes may fail for reasons of its own
UNSTEADY = ("interrupt", "process", "threads", "work_hardly_grows", "two_solves")
SWAPS = {
    "+": "-",
    "-": "+",
    "*": "/",
    "/": "*",
    "<": ">",
    ">": "<",
    "<=": "<",
    ">=": ">",
    "**": "*",
}
SWAPS |= {
    "+=": "-=",
    "-=": "+=",
    "*=": "/=",
    "/=": "*=",
    "==": "!=",
    "!=": "==",
    "and": "or",
    "or": "and",
    "not": "",
}
# lines whose numbers may change without changing a result: sizes of blocks and caches, starts of iterations, limits of
# what is worth while; errors there cost time, or guard against what no input reaches
EQUAL: tuple[tuple[str, str], ...] = (
    (
        "theory/background.py",
        "quad(flux, low, high, epsabs=0.0, epsrel=_ACCURACY / 10, limit=500, full_output=1)",
    ),
    # a tolerance below rounding stops at rounding
    ("theory/hardness.py", "accuracy = 1e-12 * max(abs(start), 1.0)"),
    # at the last temperature both refuse
    ("theory/hardness.py", "if not temperatures[0] <= start <= temperatures[-1]:"),
    # one place more stays empty
    ("roughsim/grid.py", "present = np.zeros(square.max() + 1, np.bool_)"),
    # the zeros that reach too far are written over by the next line
    (
        "roughsim/fourier/convolution.py",
        "field[:, :count], field[:, count : points - count + 1] = part[:, before:], 0.0",
    ),
)


class Mutant(NamedTuple):
    """One planted error."""

    file: str
    line: int
    old: str
    new: str
    text: str  # of the whole file

    @property
    def name(self) -> str:
        """Where it is and what it changes."""
        return f"{self.file}:{self.line}: {self.old.strip()}  →  {self.new.strip()}"

    def compiles(self) -> bool:
        """Whether Python can read it."""
        try:
            compile(self.text, self.file, "exec")
        except (SyntaxError, SyntaxWarning):
            return False
        return True


def changed(token: tokenize.TokenInfo) -> str | None:
    """What a token becomes, None if it stays."""
    if token.type in (tokenize.OP, tokenize.NAME):
        return SWAPS.get(token.string)
    if token.type == tokenize.NUMBER:
        if "e-" in token.string:
            return token.string.replace("e-", "e+")  # a tolerance twice as large is no error
        place = next((i for i, c in enumerate(token.string) if c in "123456789"), None)
        if place is None:
            return token.string.replace("0", "1", 1)
        return (
            token.string[:place]
            + str((int(token.string[place]) + 1) % 10)
            + token.string[place + 1 :]
        )
    return None


def mutants(file: str) -> Iterator[Mutant]:
    """All errors that can be planted in a file: in code that computes, not in signatures and messages."""
    source = (ROOT / file).read_text()
    lines = source.splitlines(keepends=True)
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        new = changed(token)
        if new is None:
            continue
        row, column = token.start
        line = lines[row - 1]
        if not line.startswith(" ") or _is_no_formula(line, token) or (file, line.strip()) in EQUAL:
            continue
        other = line[:column] + new + line[column + len(token.string) :]
        yield Mutant(file, row, line, other, "".join([*lines[: row - 1], other, *lines[row:]]))


def _is_no_formula(line: str, token: tokenize.TokenInfo) -> bool:
    words = (
        "raise ",
        "def ",
        "->",
        "import ",
        'f"',
        "warn(",
        "__",
        "lru_cache",
        "axis=",
        "range(",
        "shape",
    )
    column = token.start[1]
    unpacks = token.string in ("*", "**") and line[:column].rstrip()[-1:] in (
        "(",
        ",",
        "[",
        "{",
        "",
    )
    annotates = token.string == "=" or ": float = " in line or ": int = " in line
    return unpacks or annotates or any(word in line for word in words)


def modules() -> list[str]:
    """All modules of both packages that are not left out."""
    paths = [
        path.relative_to(ROOT).as_posix()
        for room in ("roughsim", "theory")
        for path in (ROOT / room).rglob("*.py")
    ]
    return sorted(path for path in paths if not path.startswith(tuple(LEFT_OUT)))


def room_tests(file: str) -> list[str]:
    """All test files of a module: the folder of its room, files with the name of its room, and files that name it."""
    package, *inside = Path(file).with_suffix("").parts
    # a folder tests/theory would shadow the package
    room = "analytic" if package == "theory" else inside[0].strip("_")
    module = ".".join([package, *inside])
    return [
        test
        for test, text in _test_files().items()
        if f"/{room}/" in test or test == f"tests/test_{room}.py" or module in text
    ]


@cache
def _test_files() -> dict[str, str]:
    """The text of each test file, and the full name of whatever it imports: `from roughsim.cli import installation`."""
    found = {}
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        text = path.read_text()
        names = [
            f"{node.module}.{name.name}"
            for node in ast.walk(ast.parse(text))
            if isinstance(node, ast.ImportFrom)
            for name in node.names
        ]
        found[path.relative_to(ROOT).as_posix()] = "\n".join([text, *names])
    return found


def drawn(each: int, seed: int, only: list[str]) -> list[Mutant]:
    """A few errors of every file, of different lines, the same for the same seed."""
    result = []
    for file in modules():
        if not any(word in file for word in only):
            continue
        found = list(mutants(file))
        rng = random.Random(f"{seed} {file}")
        rng.shuffle(found)
        lines: set[int] = set()
        for mutant in found:
            if len(lines) < each and mutant.line not in lines and mutant.compiles():
                lines.add(mutant.line)
                result.append(mutant)
    return result


class LineTests:
    """Which tests run a line, from the contexts of a coverage file."""

    def __init__(self, coverage_file: Path) -> None:
        from coverage import CoverageData

        self._data = CoverageData(str(coverage_file))
        self._data.read()
        self._sizes: Counter[str] = Counter()  # lines that each test runs in all
        for file in self._data.measured_files():
            for contexts in self._data.contexts_by_lineno(file).values():
                self._sizes.update({_test_of(context) for context in contexts})

    def of(self, file: str, line: int) -> list[str]:
        """The tests of a line, those with the fewest lines first; of the whole module if none runs the line."""
        lines = self._data.contexts_by_lineno(str(ROOT / file))
        found = {_test_of(context) for context in lines.get(line, [])} - {""}
        if not found:
            found = {_test_of(context) for contexts in lines.values() for context in contexts} - {
                ""
            }
        return sorted(found, key=lambda test: (self._sizes[test], test))


def _test_of(context: str) -> str:
    """The test of a context `file::test|phase`; its file if a fixture ran, whose result other tests may see."""
    test, _, phase = context.rpartition("|")
    return test if phase == "run" else test.partition("::")[0]


def up_to_date(coverage_file: Path) -> Path:
    """Return the coverage file, made again if a source or a test is newer."""
    sources = [
        path for room in ("roughsim", "theory", "tests") for path in (ROOT / room).rglob("*.py")
    ]
    changed_at = max(path.stat().st_mtime for path in sources)
    if not coverage_file.exists() or coverage_file.stat().st_mtime < changed_at:
        print(f"which tests run which lines: some minutes, into {coverage_file}", flush=True)
        coverage_file.parent.mkdir(exist_ok=True)
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        environment = {**os.environ, "PATH": path, "COVERAGE_FILE": str(coverage_file)}
        subprocess.run(["bash", str(ROOT / "tests/coverage.sh")], env=environment, check=True)
    return coverage_file


class Copy:
    """A private copy of the sources and tests, in which errors are planted."""

    def __init__(self, folder: Path) -> None:
        self._root = folder / "copy"
        self._caches = folder
        self._sound: set[str] = set()  # tests that pass without any error planted
        ignored = shutil.ignore_patterns("__pycache__", ".git", ".venv", "runs", "out", "build")
        shutil.copytree(ROOT, self._root, ignore=ignored)

    def notices(self, mutant: Mutant, tests: list[str]) -> bool:
        """Whether one of the tests fails with the error planted, and passes without."""
        place = self._root / mutant.file
        genuine = place.read_text()
        # numba looks at the changed file alone: a kernel that it is compiled into would be taken from the cache
        cache = f"{time.monotonic_ns()}" if "_kernels" in mutant.file else "shared"
        place.write_text(mutant.text)
        try:
            parts = [tests[:CLOSEST], tests[CLOSEST:], room_tests(mutant.file)]
            failed = next((failed for part in parts if (failed := self._failed(part, cache))), None)
        finally:
            place.write_text(genuine)
        if failed and failed not in self._sound | {"timeout"}:
            if self._failed([failed], "shared"):
                raise RuntimeError(f"{failed} fails without any error planted")
            self._sound.add(failed)
        return failed is not None

    def _failed(self, tests: list[str], cache: str) -> str | None:
        """The first test that fails, "timeout" if none ends; None if all pass."""
        if not tests:
            return None
        words = ["-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-rfE", "--no-header"]
        words += ["-k", f"not ({' or '.join(UNSTEADY)})"]
        environment = {
            **os.environ,
            "PYTHONPATH": str(self._root),
            "NUMBA_CACHE_DIR": str(self._caches / cache),
        }
        environment |= {"OMP_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}
        command = [sys.executable, *words, *tests]
        try:
            done = subprocess.run(
                command,
                cwd=self._root,
                env=environment,
                capture_output=True,
                text=True,
                timeout=600,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return "timeout"  # an error that makes a solve endless is noticed
        if done.returncode in (0, 5):  # 5: slow or unsteady tests only
            return None
        lines = [
            line for line in done.stdout.splitlines() if line.startswith(("FAILED ", "ERROR "))
        ]
        if not lines:
            raise RuntimeError(
                f"the tests {tests} could not be run: {done.stdout[-2000:]}{done.stderr[-2000:]}"
            )
        return lines[0].partition(" ")[2].partition(" - ")[0]


def main() -> int:
    """Plant, run, report; exit code 1 below nine in ten."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument(
        "--only",
        nargs="+",
        default=[""],
        metavar="WORD",
        help="files whose path holds one of these",
    )
    options.add_argument("--seed", type=int, default=1, help="another draw")
    options.add_argument("--each", type=int, default=1, help="errors per file")
    options.add_argument("--list", action="store_true", help="show what would be planted")
    given = options.parse_args()
    chosen = drawn(given.each, given.seed, given.only)
    if given.list:
        print("\n".join(mutant.name for mutant in chosen))
        return 0
    tests = LineTests(up_to_date(COVERAGE))
    missed = []
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        copy = Copy(Path(folder))
        for count, mutant in enumerate(chosen, start=1):
            own = tests.of(mutant.file, mutant.line)
            caught = copy.notices(mutant, own)
            missed += [] if caught else [mutant]
            word = "caught" if caught else f"MISSED by {len(own)} tests:"
            print(f"{count}/{len(chosen)} {word} {mutant.name}", flush=True)
    share = 1 - len(missed) / len(chosen)
    print(f"{len(chosen)} planted, {len(chosen) - len(missed)} caught: {100 * share:.1f} %")
    print("\n".join(f"missed: {mutant.name}" for mutant in missed))
    return 0 if share >= 0.9 else 1


if __name__ == "__main__":
    sys.exit(main())
