"""Pages and figures from the files of evidence: python docs/evidence.py [--check]

Each docs/evidence/NAME.json is written by one command, which it names (`experiments/script.py`); `make evidence` runs
them all. This script puts what they hold on the pages and into docs/figures; with --check it only compares, to the
printed digit, and fails with a line for each difference. A page has three marks:

    <!-- table NAME.KEY -->                       a table of the file, up to the next <!-- end of table -->
    <!-- numbers NAME: 259 = key, 390 = key -->   below a paragraph: its numbers, and their names in the file
    <!-- output NAME.KEY -->                      above a ```text block: parts of the output of a command, between …

A figure holds the names and checksums of the files it was drawn from.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
sys.path.append(str(DOCS.parent / "experiments"))


import figures  # noqa: E402

FOLDER, FIGURES = DOCS / "evidence", DOCS / "figures"
# figure → the files it is drawn from, and the function that draws their rows
DRAWN: dict[str, tuple[tuple[str, ...], Callable[..., None]]] = {
    "coverage.png": (("coverage",), figures.coverage),
    "chain.png": (("chain", "chain_ways"), figures.chain),
    "contact_error.png": (("contact",), figures.contact_error),
    "contact_cost.png": (("contact",), figures.contact_cost),
    "finite_contact.png": (("finite_contact",), figures.finite_contact),
    "heat_methods.png": (("heat",), figures.heat),
    "limits_of_solvers.png": (("limits",), figures.limits_of_solvers),
    "limits_of_pixel.png": (("limits",), figures.limits_of_pixel),
    "limits_of_heat.png": (("limits",), figures.limits_of_heat),
    "limits_of_theory.png": (("limits",), figures.limits_of_theory),
}
_TABLE = re.compile(r"(?ms)^<!-- table ([\w-]+)\.([\w-]+) -->\n(.*?)^<!-- end of table -->$")
_NUMBERS = re.compile(r"(?m)^<!-- numbers ([\w-]+): (.*?) -->$")
_OUTPUT = re.compile(r"(?ms)^<!-- output ([\w-]+)\.([\w-]+) -->\n+```text\n(.*?)^```$")
_WORD = r"(?<![\w.]){}(?![\w]|\.\d)"  # a number that is no part of another


def pages() -> list[Path]:
    """Return all pages."""
    return [DOCS.parent / "README.md", *sorted(DOCS.rglob("*.md"))]


def evidence(name: str) -> dict[str, Any]:
    """Return a file of evidence; LookupError with what to do if there is none."""
    path = FOLDER / f"{name}.json"
    if not path.exists():
        raise LookupError(f"docs/evidence/{name}.json is missing; `make evidence` writes it")
    return dict(json.loads(path.read_text("utf-8")))


def held(name: str, kind: str, key: str) -> Any:
    """Return a table, number or text of a file by its name; LookupError if it has none of that name."""
    found = evidence(name).get(kind, {})
    if key not in found:
        raise LookupError(
            f"docs/evidence/{name}.json has no {kind} named {key}; it has {', '.join(found) or 'none'}"
        )
    return found[key]


def table(rows: list[list[str]]) -> str:
    """Return rows of cells, the first of them the heads, as Markdown."""
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join(["", lines[0], "|---" * len(rows[0]) + "|", *lines[1:], "", ""])


def with_tables(text: str) -> str:
    """Return the text of a page with its tables from the files."""

    def made(found: re.Match[str]) -> str:
        name, key, _ = found.groups()
        rows = held(name, "tables", key)
        return f"<!-- table {name}.{key} -->\n{table(rows)}<!-- end of table -->"

    return _TABLE.sub(made, text)


def printed_as(value: float, shown: str) -> str:
    """Return a number with as many decimals as another has that is shown."""
    decimals = len(shown.partition(".")[2])
    return f"{value:.{decimals}f}".replace("-", "−" if "−" in shown else "-")


def wrong_numbers(text: str) -> Iterator[str]:
    """Yield a line for each number of a paragraph that is not there, or not that of its file."""
    for found in _NUMBERS.finditer(text):
        paragraph = text[: found.start()].rstrip("\n").rpartition("\n\n")[2]
        for pair in found[2].split(", "):
            shown, key = pair.split(" = ")
            if not re.search(_WORD.format(re.escape(shown)), paragraph):
                yield f"{shown} ({key}) is not in the paragraph above its mark"
            right = printed_as(held(found[1], "numbers", key), shown)
            if right != shown:
                yield f"{shown} should be {right}: {key} of docs/evidence/{found[1]}.json"


def shows(block: str, whole: str) -> bool:
    """Return whether the parts of a block, between its …, follow one another in a text from its start to its end."""
    first, *others = (" ".join(part.split()) for part in block.split("…"))
    rest = " ".join(whole.split())
    if not others:
        return rest == first
    if not rest.startswith(first):
        return False
    rest = rest.removeprefix(first)
    for part in others[:-1]:
        _, found, rest = rest.partition(part) if part else ("", "…", rest)
        if not found:
            return False
    return rest.endswith(others[-1])


def wrong_outputs(text: str) -> Iterator[str]:
    """Yield a line for each block of output that is not, in all words and digits, that of its file."""
    for name, key, block in _OUTPUT.findall(text):
        whole = held(name, "texts", key)
        if not shows(block, whole):
            yield f"the output {name}.{key} is other than shown:\n{whole}"


def source(names: tuple[str, ...]) -> str:
    """Return the files of a figure with their checksums, as the figure holds them."""
    sums = (
        f"{name}.json {sha256((FOLDER / f'{name}.json').read_bytes()).hexdigest()[:16]}"
        for name in names
    )
    return ", ".join(sums)


def draw() -> None:
    """Draw the figures whose files have changed since."""
    for figure, (names, function) in DRAWN.items():
        if differs(figure, names):
            function(*(evidence(name)["rows"] for name in names), FIGURES / figure, source(names))
            print(f"drawn: docs/figures/{figure}")


def differs(figure: str, names: tuple[str, ...]) -> bool:
    """Return whether a figure is missing, or was drawn from other files."""
    path = FIGURES / figure
    return not path.exists() or source(names).encode() not in path.read_bytes()


def differences(chosen: list[Path]) -> list[str]:
    """Return a line for each number, table or figure that is not what the files hold."""
    lines = []
    for page in chosen:
        text, name = page.read_text("utf-8"), page.relative_to(DOCS.parent)
        try:
            lines += [f"{name}: {line}" for line in (*wrong_numbers(text), *wrong_outputs(text))]
            if with_tables(text) != text:
                lines.append(
                    f"{name}: a table is not that of its file; run python docs/evidence.py"
                )
        except LookupError as error:
            lines.append(f"{name}: {error.args[0]}")
    drawn = (figure for figure, (names, _) in DRAWN.items() if differs(figure, names))
    return lines + [
        f"docs/figures/{figure} is not drawn from its files; run python docs/evidence.py"
        for figure in drawn
    ]


def main() -> None:
    """Write tables and figures, or compare; then exit with the differences."""
    if "--check" not in sys.argv[1:]:
        draw()
        for page in pages():
            text = page.read_text("utf-8")
            if with_tables(text) != text:
                page.write_text(with_tables(text), "utf-8")
                print(f"written: {page.relative_to(DOCS.parent)}")
    if lines := differences(pages()):
        sys.exit("\n".join(lines))


if __name__ == "__main__":
    main()
