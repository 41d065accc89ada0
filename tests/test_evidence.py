"""Numbers of pages come from the files of docs/evidence, and are compared with them to the printed digit."""

import importlib.util
import json
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILE = {
    "numbers": {"hot": 389.6276, "change": -0.0347},
    "tables": {"flash": [["scene", "K"], ["steel", "389.6 ± 4.7"]]},
    "texts": {"theory": "T_flash\n35  155.7  102.4\ndone\n"},
    "rows": [],
}


@pytest.fixture
def evidence(tmp_path, monkeypatch):
    """The script, with one file named `steel` in a folder of its own."""
    specification = importlib.util.spec_from_file_location(
        "evidence", ROOT / "docs" / "evidence.py"
    )
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    monkeypatch.setattr(module, "FOLDER", tmp_path)
    monkeypatch.setattr(module, "FIGURES", tmp_path)
    monkeypatch.setattr(module, "DOCS", tmp_path / "docs")
    monkeypatch.setattr(module, "DRAWN", {})
    (tmp_path / "docs").mkdir()
    (tmp_path / "steel.json").write_text(json.dumps(FILE))
    return module


def differences(evidence, text):
    page = evidence.DOCS / "page.md"
    page.write_text(text)
    return evidence.differences([page])


def test_make_evidence_runs_the_command_of_every_file():
    recipe = (ROOT / "Makefile").read_text()
    commands = [
        json.loads(path.read_text())["command"]
        for path in sorted((ROOT / "docs" / "evidence").iterdir())
    ]
    assert [
        command for command in commands if f"{command.removeprefix('python ')}\n" not in recipe
    ] == []


@pytest.mark.parametrize(
    ("shown", "key", "right"),
    [
        ("390", "hot", None),
        ("389.6", "hot", None),
        ("389.7", "hot", "389.6"),
        ("397", "hot", "390"),
        ("−0.03", "change", None),
        ("-0.035", "change", None),
        ("−0.04", "change", "−0.03"),
        ("0.03", "change", "-0.03"),
    ],
)
def test_a_number_is_compared_to_its_last_digit(evidence, shown, key, right):
    found = differences(
        evidence, f"# Page\n\nSteel has {shown} K.\n<!-- numbers steel: {shown} = {key} -->\n"
    )
    expected = f"docs/page.md: {shown} should be {right}: {key} of docs/evidence/steel.json"
    assert found == ([] if right is None else [expected])


def test_a_mark_needs_its_number_in_the_paragraph_above_it_and_its_name_in_the_file(evidence):
    mark = "<!-- numbers steel: 390 = hot -->\n"
    assert differences(evidence, f"390 K.\n\nSteel.\n{mark}") == [
        "docs/page.md: 390 (hot) is not in the paragraph above its mark"
    ]
    assert "is not in the paragraph" in differences(evidence, f"1390 K, 390.1 K.\n{mark}")[0]
    assert differences(evidence, f"Of 390.\n{mark}") == []
    unknown = differences(evidence, "1\n<!-- numbers steel: 1 = cold -->\n")
    assert "no numbers named cold; it has hot, change" in unknown[0]
    missing = differences(evidence, "1\n<!-- numbers gold: 1 = hot -->\n")
    assert "docs/evidence/gold.json is missing" in missing[0]


def test_a_table_is_written_between_its_marks_and_nothing_else_changes(evidence):
    text = "before\n\n<!-- table steel.flash -->\n| old |\n<!-- end of table -->\n\nafter\n"
    assert differences(evidence, text) == [
        "docs/page.md: a table is not that of its file; run python docs/evidence.py"
    ]
    written = evidence.with_tables(text)
    assert written == text.replace(
        "| old |\n", "\n| scene | K |\n|---|---|\n| steel | 389.6 ± 4.7 |\n\n"
    )
    assert differences(evidence, written) == []
    assert differences(evidence, written.replace("389.6", "389.7")) != []


def test_output_is_compared_in_all_words_and_digits_with_gaps_where_it_says_so(evidence):
    def found(block):
        return differences(evidence, f"<!-- output steel.theory -->\n\n```text\n{block}\n```\n")

    assert found("T_flash\n…\ndone") == []
    assert found("T_flash\n35 155.7 102.4\ndone") == []
    assert found("T_flash\n35 155.… 102.4\ndone") == []
    assert len(found("T_flash\n35 155.8 102.4\ndone")) == 1  # one unit of the last digit
    assert len(found("T_flash\n35 155.7 102.4")) == 1
    assert len(found("35 155.7 102.4\n…")) == 1


def test_a_figure_is_drawn_again_when_its_file_has_changed(evidence, monkeypatch):
    drawn = []

    def draw(rows, path, source):
        drawn.append(rows)
        path.write_bytes(b"picture " + source.encode())

    monkeypatch.setattr(evidence, "DRAWN", {"steel.png": (("steel",), draw)})
    late = ["docs/figures/steel.png is not drawn from its files; run python docs/evidence.py"]
    assert evidence.differences([]) == late
    evidence.draw()
    evidence.draw()
    assert (drawn, evidence.differences([])) == ([[]], [])
    (evidence.FOLDER / "steel.json").write_text(json.dumps(FILE | {"rows": [1]}))
    assert evidence.differences([]) == late


@pytest.mark.parametrize(
    ("block", "shown"),
    [
        ("one  two\nthree", True),
        ("one … three", True),
        ("… two …", True),
        ("one …", True),
        ("two …", False),
        ("one … two", False),
        ("one … three … two …", False),
        ("one two", False),
    ],
)
def test_an_output_is_shown_from_its_start_to_its_end(evidence, block, shown):
    assert evidence.shows(block, "one two three\n") is shown


def test_an_output_that_differs_is_told_at_once(evidence):
    assert not evidence.shows("… ".join(f"word {k}" for k in range(200)), "word 0 other " * 5000)
