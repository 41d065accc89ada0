"""Every example of README.md and docs/ runs, and what the pages say of the code is so.

The blocks of a page run in their order, in one empty folder. Large scenes are replaced by a small one, and a page that
only reads a run finds a small one at runs/steel. The line above a block can mark it: `<!-- slow -->` leaves its whole
page to the slow tests (as README.md is), `<!-- not run: REASON -->` leaves it out. A ```text block is what the block
above it prints: the same words, numbers to the last digit but for one unit, and … for whatever may differ.
"""

import contextlib
import importlib.util
import io
import json
import os
import re
import shutil
import subprocess
import sys
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

import pytest
from scene_keys import KEYS
from small_scene import CAPPED

import roughsim
import theory
from roughsim import cli

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
BLOCK = re.compile(
    r"(?:^<!-- ([^\n]*) -->\n+)?^```(python|console|text|toml)\n(.*?)^```", re.MULTILINE | re.DOTALL
)
OPTIONAL = (
    "xarray",
    "h5netcdf",
    "netCDF4",
    "nexusformat",
    "dask",
    "mpi4py",
    "SurfaceTopography",
    "bokeh",
    "tamaas",
)
WORDS = {
    "errors.md": 2000,
    "yielding.md": 1800,
    "accuracy.md": 1500,
    "validity.md": 1500,
}  # at most; others 1200
WRITTEN = re.compile(r"<!-- \w+: written by docs/flow\.py -->.*?<!-- end -->", re.DOTALL)
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
LARGE = re.compile(r"\bsteel-\d\.\dGPa(?![\w.])")
NUMBER = re.compile(r"(?<![\w.])[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
COMMANDS = {"roughsim": f"{sys.executable} -m roughsim", "python": sys.executable}


class Block(NamedTuple):
    mark: str
    kind: str
    text: str


def blocks(page):
    return [Block(*found) for found in BLOCK.findall(page.read_text())]


def name(page):
    return str(page.relative_to(ROOT))


def is_slow(page):
    return page.name == "README.md" or any(block.mark == "slow" for block in blocks(page))


def missing(text):
    """The first optional package that a block imports and that is not installed."""
    wanted = (other for other in OPTIONAL if re.search(rf"(from|import) {other}\b", text))
    return next((other for other in wanted if importlib.util.find_spec(other) is None), None)


def printed(block, names):
    """Run one block in the current folder; return its output."""
    text = re.sub(r"workers=\d+", "workers=2", LARGE.sub("small.toml", block.text))
    if block.kind == "console":
        return "".join(command(line[2:]) for line in text.splitlines() if line.startswith("$ "))
    if "__main__" in text:  # spawns processes, which import the script again
        Path("script.py").write_text(text)
        return command("python script.py")
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(compile(text, "example", "exec"), names)
    return output.getvalue()


def command(line):
    word, rest = line.split(" ", 1)
    if word not in COMMANDS:  # pip install, cd, less, …
        return ""
    environment = os.environ | {"PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
    done = subprocess.run(
        f"{COMMANDS[word]} {rest}",
        shell=True,
        text=True,
        check=False,
        capture_output=True,
        env=environment,
        timeout=300,
    )
    assert done.returncode == 0, f"{line}\n{done.stderr}"
    return done.stdout + done.stderr


def close(shown, found):
    """Whether two words are the same but for one unit of the last digit of their numbers, and 2 % at most."""
    if NUMBER.sub("#", shown) != NUMBER.sub("#", found):
        return False
    pairs = zip(
        *([n.replace("−", "-") for n in NUMBER.findall(word)] for word in (shown, found)),
        strict=True,
    )
    return all(
        abs(float(a) - float(b)) <= min(1.001 * last_digit(a), 0.02 * abs(float(a)))
        for a, b in pairs
    )


def last_digit(number):
    """One unit of the last digit of a number as written."""
    return 10.0 ** Decimal(number).as_tuple().exponent


def shows(expected, output):
    """Whether the parts of `expected` between … follow one another in the output, from its start to its end.

    A comma belongs to the word that … stands for.
    """
    words, position = output.split(), 0
    parts = [part.split() for part in re.split("…,?", expected)]
    for number, part in enumerate(parts):
        last = len(words) - len(part)
        starts = range(position, last + 1) if number else range(min(1, last + 1))
        if number == len(parts) - 1:
            starts = [start for start in starts if start == last]
        hit = next((i for i in starts if all(map(close, part, words[i : i + len(part)]))), None)
        if hit is None:
            return False
        position = hit + len(part)
    return True


def run_page(page, capped_run):
    Path("small.toml").write_text(CAPPED)
    found = blocks(page)
    if not any("rs.run(" in block.text or "roughsim run" in block.text for block in found):
        shutil.copytree(capped_run.folder, "runs/steel")
    names, output, left_out = {"__name__": "example"}, "", []
    for block in found:
        package = missing(block.text)
        if block.kind == "toml" or block.mark.startswith("not run: "):
            continue
        if block.kind == "text":
            assert shows(block.text, output), f"shown:\n{block.text}\nfound:\n{output}"
        elif package is not None:
            left_out.append(package)
        else:
            output = printed(block, names)
    if left_out:
        pytest.skip(f"all but the examples with {', '.join(left_out)}, which is not installed")


@pytest.mark.parametrize(
    "page", [page for page in PAGES if blocks(page) and not is_slow(page)], ids=name
)
def test_every_example_runs(page, in_tmp_path, capped_run):
    run_page(page, capped_run)


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PAGES if is_slow(page)], ids=name)
def test_every_slow_example_runs(page, in_tmp_path, capped_run):
    run_page(page, capped_run)


def test_shown_output_is_compared_word_by_word_and_numbers_to_the_last_digit():
    assert shows("a 100 K … end", "a 101 K\n 5 s  end\n")
    assert shows("a 100 ± …, end", "a 101 ± 3, end")
    assert shows("155.7 -3.2e-05", "155.8 -3.3e-05") is False  # 3 % of the second
    assert shows("155.7 -3.21e-05", "155.8 -3.22e-05")
    assert not shows("155.7", "155.9")
    assert not shows("9", "10")
    assert not shows("a 100 K … end", "a 103 K 5 s end")
    assert not shows("a 100 K", "a 100 K and more")
    assert not shows("a 100 K … end", "b 100 K 5 s end")
    assert not shows("a -1", "a 1")


def script(stem):
    """A script of docs/ as a module."""
    specification = importlib.util.spec_from_file_location(stem, DOCS / f"{stem}.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_the_picture_and_the_table_of_the_modules_are_those_of_the_imports():
    flow = script("flow")
    graph = flow.imports()
    assert "scene" in graph["planning"]
    assert "theory" in graph["prediction"]
    after = "run python docs/flow.py"
    assert flow.DATA.read_text() == flow.data_picture(), after
    assert set(flow.ROOMS) - {"theory"} <= set(graph)
    assert flow.PICTURE.read_text() == flow.picture(graph), after
    assert flow.PAGE.read_text() == flow.page(flow.PAGE.read_text(), graph), after
    assert "    active_set.py " in flow.PAGE.read_text()


def test_the_page_of_the_scene_has_every_key_with_unit_limits_default_and_meaning():
    page = script("lists").scene_keys() + (DOCS / "reference" / "scene.md").read_text()
    assert {key for key in KEYS if f"`{key}`" not in page} == set()
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| `")]
    assert all(len(row) == 6 and all(row) for row in rows)
    cells = {row[0].strip("`"): row[1:] for row in reversed(rows)}  # levels have some keys again
    assert cells["youngs_modulus"][:3] == ["Pa", "> 0", "needed"]
    assert cells["poisson_ratio"][1] == "> -1, ≤ 0.5"
    assert cells["history"][1:3] == ['`"frozen"`, `"sliding"`', '`"frozen"`']
    assert cells["gamma"][2] == "`0.45`"
    assert (cells["lengths"][2], cells["q_roll_off"][2], cells["tolerance"][2]) == (
        "planned",
        "left out",
        "`0.003`",
    )


def test_the_page_of_the_commands_has_the_help_of_every_verb():
    page = script("lists").commands()
    verbs = [info.name or info.callback.__name__ for info in cli.app.registered_commands]
    assert re.findall(r"(?m)^## (.*)$", page) == verbs
    assert [re.search(rf"Usage: roughsim {verb} \[OPTIONS\]", page) for verb in verbs].count(
        None
    ) == 0
    assert page.count("-h, --help") == len(verbs)


def test_the_reference_has_every_public_name():
    listed = set(
        re.findall(
            r"\.\. auto\w+:: roughsim::(\w+)", (DOCS / "reference" / "roughsim.md").read_text()
        )
    )
    assert listed == set(roughsim.__all__) - {"__version__"}
    listed = set(
        re.findall(
            r"\.\. automodule:: theory\.(\w+)", (DOCS / "reference" / "theory.md").read_text()
        )
    )
    assert listed == set(theory.__all__)


def test_every_test_that_a_page_names_exists():
    defined = {
        found
        for path in (ROOT / "tests").rglob("test_*.py")
        for found in re.findall(r"^def (test_\w+)", path.read_text(), re.M)
    }
    for page in PAGES:
        assert set(re.findall(r"`(test_\w+)`", page.read_text())) - defined == set(), page


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"])
def test_links_beside_the_site_lead_somewhere(page):  # the build looks at those of docs/
    for target in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", (ROOT / page).read_text()):
        assert (ROOT / target).exists(), target


@pytest.mark.parametrize("path", sorted(DOCS.rglob("*.ipynb")), ids=name)
def test_notebooks_are_stored_without_results(path):  # the build runs them
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        assert (cell.get("outputs", []), cell.get("execution_count")) == ([], None)


def test_pages_are_short_alone_and_together():
    # as `wc -w` counts them, but for comments, which no page shows, and the two lists of modules that a script writes
    words = {
        page: len(COMMENT.sub("", WRITTEN.sub("", page.read_text())).split()) for page in PAGES
    }
    assert {
        name(page): count for page, count in words.items() if count > WORDS.get(page.name, 1200)
    } == {}
    assert sum(words.values()) <= 20_000


def test_every_figure_is_on_a_page():
    text = "".join(page.read_text() for page in PAGES)
    assert [
        path.name for path in sorted((DOCS / "figures").iterdir()) if path.name not in text
    ] == []


@pytest.mark.parametrize(
    "page", [ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *PAGES], ids=name
)
def test_every_file_that_a_page_names_exists(page):
    named = re.findall(
        r"(?<![\w/.-])((?:roughsim|theory|tests|docs|experiments|benchmarks)/[\w/]+\.\w+)",
        page.read_text(),
    )
    files = {path for path in named if "NAME" not in path}
    assert len(files) > (15 if page.name == "CONTRIBUTING.md" else -1)
    assert [path for path in sorted(files) if not (ROOT / path).exists()] == []
