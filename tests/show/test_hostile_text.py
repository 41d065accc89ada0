"""Titles and paths that look like markup, formulas, HTML or commands to the terminal: text, in every output."""

import os
import shutil
import warnings
import xml.etree.ElementTree as ET
from contextlib import chdir
from dataclasses import replace
from html import escape
from importlib.util import find_spec
from pathlib import Path

import pytest

import roughsim as rs
from roughsim import cli
from roughsim.scene import parse_scene
from roughsim.show.table import table_text
from roughsim.show.text import errors_in_one_line, plain

PAGE = ("explore",) if find_spec("bokeh") else ()  # an extra
TITLES = {
    "mixed": "[bold]x[/nope] [/] :smile: {0} %s ${name} <script>alert(1)</script> &amp; \"'> ]]> \\",
    "formula": "$\\frac{ $ ^ _ \\ $x$ $$y$$ \\$ \\\\$",
}
FOLDERS = (
    "[bold]x[nope] $\\frac{ <script> {0} %s",
    "a\x1b[31mb\x1b]0;owned\x07\u202e",
    "a\udcffb",
    "-",
    "[]",
)
PLOTS = (
    "heights",
    "pressure",
    "temperature",
    "heat_flux",
    "distribution",
    "spectrum",
    "correlation",
    "profile",
)


@pytest.fixture
def told(capsys):
    """Runs the command line in this process; what it prints commands no terminal and takes no bracket away."""

    def call(*words, expect=0):
        with pytest.raises(SystemExit) as ended:
            cli.main([os.fspath(word) for word in map(str, words)])
        printed = capsys.readouterr()
        text = printed.out + printed.err
        assert ended.value.code == expect, text
        assert [c for c in text if not c.isprintable() and c not in "\n"] == []
        return text

    return call


@pytest.fixture(scope="module")
def runs(capped_scene, tmp_path_factory):
    """Small runs by the name of their title, made when they are asked for."""
    made = {}

    def of(name):
        if name not in made:
            numerics = replace(
                capped_scene.numerics,
                levels=({"column": "capped", "shape": [32, 32], "q_max": 4e4},),
                keep_fields=1,
            )
            scene = replace(capped_scene, title=TITLES[name], numerics=numerics)
            made[name] = rs.run(
                scene, tmp_path_factory.mktemp("hostile") / name, max_realizations=2
            ).folder
        return made[name]

    return of


def squeezed(text):
    return "".join(text.split())


def has(text, title):
    """Whether the title stands in a text that may have been wrapped into a table."""
    return squeezed(plain(title)) in squeezed(text)


@pytest.mark.parametrize("name", TITLES)
def test_a_title_survives_its_scene_file(capped_scene, name):
    scene = replace(capped_scene, title=TITLES[name])
    assert parse_scene(scene.to_toml()).title == TITLES[name]


def test_every_table_and_line_shows_a_title_as_it_is(told, runs, capped_scene, tmp_path):
    folder = runs("mixed")
    (tmp_path / "scene.toml").write_text(replace(capped_scene, title=TITLES["mixed"]).to_toml())
    for words in (("theory", tmp_path / "scene.toml"), ("status", folder), ("compare", folder)):
        assert has(told(*words), TITLES["mixed"]), words


@pytest.mark.slow
@pytest.mark.parametrize("name", TITLES)
def test_every_verb_takes_a_title_for_text(told, runs, tmp_path, name):
    folder, title = runs(name), TITLES[name]
    scene = folder / "scene.toml"
    for words in (("theory", scene, "--trust"), ("status", folder), ("compare", folder)):
        assert has(told(*words), title), words
    told("plan", scene)
    told("run", scene, "-o", tmp_path / "again", "--max", 2, "--workers", 1)
    told("bench", scene, "--stage", "contact", "--chart", tmp_path / "bench.png")
    for verb in ("theory", "plan"):
        told(verb, scene, "--json")
    for verb in ("status", "compare"):
        told(verb, folder, "--json")
    told("report", folder, "-o", tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "<script" not in page
    assert escape(title) in page
    told("export", folder, "-o", tmp_path / "file.h5")
    with chdir(folder):
        told("doctor")
        told("new", "[/]", expect=1)


@pytest.mark.slow
@pytest.mark.parametrize("name", TITLES)
def test_every_chart_shows_a_title_letter_by_letter(told, runs, tmp_path, name):
    folder = runs(name)
    told("compare", folder, "--chart", tmp_path / "comparison.svg")
    for quantity in PLOTS:
        told("plot", folder, quantity, "-o", tmp_path / f"{quantity}.svg")
    told("plot", folder, "temperature", "--side-by-side", "-o", tmp_path / "beside.svg")
    pictures = sorted(tmp_path.glob("*.svg"))
    assert len(pictures) == len(PLOTS) + 2
    for picture in pictures:
        words = "".join(
            ET.parse(picture).getroot().itertext()
        )  # a file with control characters is not XML
        start = squeezed(plain(TITLES[name]))[:20]
        assert start in squeezed(words), picture


@pytest.mark.slow
@pytest.mark.parametrize("name", FOLDERS)
def test_a_folder_may_have_any_name(told, runs, tmp_path, name):
    folder = Path(shutil.copytree(runs("mixed"), tmp_path / name))
    text = told("status", folder)
    assert squeezed(plain(name)) in squeezed(text)
    told("plot", folder, "pressure")
    told("export", folder, "-o", folder / "file.h5")
    told("run", folder / "scene.toml", "-o", folder, "--max", 2, "--workers", 1)
    (folder / "members.h5").write_bytes(b"damaged")
    assert squeezed(plain(name)) in squeezed(told("status", folder))
    for verb in ("compare", *PAGE):
        assert squeezed(plain(name)) in squeezed(told(verb, folder / "missing", expect=1))


def test_a_file_in_place_of_a_run_is_named(told, tmp_path):
    (tmp_path / "[x].toml").write_text("")
    for verb in ("status", "compare"):
        assert "[x].toml is a file; name the folder of a run" in told(
            verb, tmp_path / "[x].toml", expect=1
        )


def test_letters_that_the_font_lacks_are_named_once_for_all_pictures(
    capsys, theory_table, tmp_path
):
    from matplotlib.figure import Figure

    from roughsim.charts.style import save

    def draw(scene):
        for _ in range(2):
            figure = Figure(figsize=(1, 1))
            figure.text(0, 0, "σ 日本")
            save(figure, tmp_path / "x.png")
        return ""

    theory_table(draw)
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        with pytest.raises(SystemExit):
            cli.main(["theory", "demo", "--all"])
    (line,) = capsys.readouterr().err.splitlines()
    assert (
        line == "roughsim: warning: the font of the pictures has no 日 本: boxes are drawn instead"
    )


def test_words_that_the_command_line_does_not_know_are_shown_as_they_are(told):
    text = told("status", "a", "b\x1b[31m[/bold]", expect=2)
    assert "[/bold]" in text
    assert "\x1b" not in text


def test_a_title_with_commands_to_the_terminal_is_refused_in_words_without_them(told, tmp_path):
    (tmp_path / "scene.toml").write_text('title = "a\\u001b[31m \\u0000 \\u202e"\n[\\u001b]\n')
    assert "scene.toml" in told("theory", tmp_path / "scene.toml", expect=1)
    (tmp_path / "scene.toml").write_text('title = "a\\u001b[31m \\u007f"\n["\\u001b[31m"]\nx = 1\n')
    assert "is not a key of a scene" in told("theory", tmp_path / "scene.toml", expect=1)


@pytest.mark.parametrize("name", FOLDERS)
def test_a_path_in_an_error_commands_no_terminal(told, tmp_path, name):
    for verb in ("compare", "status", "theory", *PAGE):
        text = told(verb, tmp_path / name / "missing.toml", expect=1)
        assert squeezed(plain(name)) in squeezed(text)
        assert text.count("\n") == 1


def test_plain_text_is_one_printable_line():
    assert (
        plain("a\x1b[31mb\x9b\u202e\udcff[/b] :x: \n\t$x$ é 漢 ±")
        == "a?[31mb???[/b] :x:   $x$ é 漢 ±"
    )


def test_a_narrow_terminal_cuts_no_number(capped_run):
    text = table_text(rs.compare(capped_run).table(), 40)
    assert "…" not in text
    rows = (line for line in text.splitlines() if line.startswith("contact_fraction"))
    assert "".join(rows).count("±") == 4  # in blocks of columns below one another


def test_a_long_error_is_cut_in_its_middle(capsys):
    for count, words in ((600, "a" * 600 + "b" * 600), (601, "a" * 600 + " … " + "b" * 600)):
        with pytest.raises(SystemExit), errors_in_one_line("roughsim run"):
            raise ValueError("a" * count + "b" * 600)
        assert capsys.readouterr().err == f"roughsim: {words}\n"


def test_a_folder_with_a_command_to_the_terminal_is_plain_in_python_too(capped_run, tmp_path):
    folder = shutil.copytree(capped_run.folder, tmp_path / "run\x1b[31m")
    run = rs.open_run(folder)
    (folder / "run.json").unlink()
    with pytest.raises(rs.RecordError, match="is no run") as refused:
        rs.open_run(folder)
    for text in (str(refused.value), repr(run), str(rs.status(run))):
        assert "run?[31m" in text
        assert "\x1b" not in text
