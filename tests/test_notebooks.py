"""The notebooks of docs/: stored without results, in place on the site, and every cell runs."""

import json
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))


def cells(path):
    return json.loads(path.read_text(encoding="utf-8"))["cells"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_stored_without_results_and_is_on_the_site(path):
    for cell in cells(path):
        assert cell.get("outputs", []) == []
        assert cell.get("execution_count") is None
        assert all(len(line) <= 130 for line in cell["source"] if not line.startswith("|"))
    assert f"notebooks/{path.stem}\n" in (DOCS / "index.md").read_text()


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_pages_that_a_notebook_names_exist(path):
    text = "".join("".join(cell["source"]) for cell in cells(path))
    for target in re.findall(r"\]\((?!http)([^)#]+)", text):
        assert (path.parent / target).exists(), target


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_cell_of_a_notebook_runs(path, in_tmp_path):
    pytest.importorskip("IPython")
    names = {}
    for cell in cells(path):
        if cell["cell_type"] == "code":
            source = re.sub(r"workers=\d+", "workers=1", "".join(cell["source"]))
            exec(compile(source, path.stem, "exec"), names)
