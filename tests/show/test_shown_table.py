"""One table in a terminal of any width and as plain text: numbers whole, names once, nothing lost."""

import pytest

from roughsim.cli.words import print_parts
from roughsim.show.table import Column, Number, Table, table_of, table_text

COLUMNS = (
    Column("observable", name=True),
    Column("value, µm (of all)", number=True),
    Column("because"),
)
ROWS = (
    (
        "slope_length, µm",
        Number(2e-4, "m", 1.2e-6),
        "a reason of several words that may be broken between any two",
    ),
    ("slope_length, µm", Number(3e-4, "m"), "[bold]no markup[/] :smile:"),
    ("flash_width, µm", Number(float("nan"), "m"), ""),
)
TABLE = Table(COLUMNS, ROWS, "Title", ("A note of two lines:\nhere.",))


def test_a_group_is_named_once_and_numbers_stand_right():
    lines = table_text(TABLE, 120).splitlines()
    assert lines[0] == "Title"
    assert [line.split() for line in lines[1:3]] == [
        ["value,", "µm"],
        ["observable", "(of", "all)", "because"],
    ]
    assert lines[3].startswith("slope_length, µm ")
    assert lines[4].startswith(" " * len("slope_length, µm"))
    assert (
        lines[3].index("a reason")
        == lines[4].index("[bold]no markup[/] :smile:")
        == lines[2].index("because")
    )
    assert (
        lines[3].index("a reason") - 2
        == len(lines[3].partition(" 1.2")[0] + " 1.2")
        == lines[4].index("300") + 3
    )
    assert lines[5].split() == ["flash_width,", "µm", "–"]
    assert lines[6:] == ["A note of two lines:", "here."]


@pytest.mark.parametrize("width", [10, 40, 60])
def test_a_narrow_terminal_wraps_text_but_breaks_no_number_and_no_name(width):
    text = table_text(TABLE, width)
    assert "200.0 ± 1.2" in text
    assert "slope_length, µm" in text
    words = "".join(text.split())
    for _, _, reason in ROWS:
        for word in reason.split():
            assert word in words
    assert max(len(line) for line in text.splitlines()) <= max(width, 46)


def test_a_table_without_titles_has_no_line_of_them():
    (line,) = table_text(Table([Column("")] * 2, [("a", "b")])).splitlines()
    assert line.split() == ["a", "b"]


def test_narrow_table_goes_on_below_its_heads():
    columns = [Column("observable", name=True), *(Column(f"q{k}", number=True) for k in range(4))]
    row = ["T_flash", *(Number(10.0**k, error=1.0) for k in range(4))]
    table = Table(columns, [row])
    assert len(table_text(table, 60).splitlines()) == 2
    lines = table_text(table, 40).splitlines()
    assert max(map(len, lines)) <= 40
    assert [line.split()[0] for line in lines if line] == ["observable", "T_flash"] * 2
    whole = " ".join(" ".join(lines).split())
    assert all(str(cell) in whole for cell in row)


def test_words_are_broken_nowhere():
    words = ["a_word_of_29_letters_as_of_key", "pressure_variance"]
    table = Table([Column("choice"), Column("because")], [words, words[::-1]])
    lines = table_text(table, 20).splitlines()
    assert all(word in " ".join(lines) for word in words)


def test_columns_is_the_width_of_a_pipe(monkeypatch):
    for width in (40, 60):
        monkeypatch.setenv("COLUMNS", str(width))
        assert str(TABLE) == table_text(TABLE, width)
    monkeypatch.delenv("COLUMNS")
    assert str(TABLE) == table_text(TABLE, 150)


def test_tables_stand_apart_and_lines_do_not(capsys):
    print_parts("line", TABLE, Table([Column("")], [("end",)]), "line")
    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    assert lines[:2] == ["line", "Title"]
    assert lines[-3:] == ["", "end", "line"]


def test_a_name_is_written_again_where_a_name_to_its_left_is_another():
    columns = [Column("", name=True), Column("", name=True)]
    table = Table(columns, [["pressure", "0.18"], ["area", "0.18"], ["area", "0.18"]])
    assert table.cells(0) == ["pressure", "area", ""]
    assert table.cells(1) == ["0.18", "0.18", ""]
    assert Table(columns, [["area", "1"], ["area", "1"]]).cells(0) == [
        "area",
        "",
    ]  # all rows are of one group


def test_rows_by_titles_make_columns_in_their_order():
    rows = [{"name": "a", "v": "1", "T": Number(2.0)}, {"name": "b", "T": Number(3.0), "n": "x"}]
    table = table_of(rows, "title", ["note"], names=["name"], texts=["n"])
    assert [(c.title, c.number, c.name) for c in table.columns] == [
        ("name", False, True),
        ("v", True, False),
        ("T", True, False),
        ("n", False, False),
    ]
    assert [list(row) for row in table.rows] == [
        ["a", "1", Number(2.0), ""],
        ["b", "", Number(3.0), "x"],
    ]
    assert (table.title, table.notes, table.heads) == ("title", ["note"], 2)
    assert table_of([{"v": "1", "w": "2"}]).heads == 1  # without a number
