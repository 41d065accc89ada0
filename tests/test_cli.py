"""The command line as a newcomer meets it: tables, JSON, and errors of one line."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from roughsim import cli
from roughsim.scene import bundled_scenes

ROOT = Path(__file__).parents[1]


def call(*words, expect=0):
    """Run the command in a process of its own; return what it printed and complained."""
    done = subprocess.run(
        [sys.executable, "-m", "roughsim", *map(str, words)],
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=False,
    )
    assert done.returncode == expect, done.stderr
    assert "Traceback" not in done.stderr
    return done.stdout, done.stderr


def inside(capsys, *words):
    """Run the command in this process."""
    with pytest.raises(SystemExit) as ended:
        cli.main(list(map(str, words)))
    printed = capsys.readouterr()
    return ended.value.code, printed.out, printed.err


def test_theory_prints_the_steel_table(capsys):
    code, out, _ = inside(capsys, "theory", "steel-1.2GPa", "--json")
    told = json.loads(out)
    k = told["speed"].index(35.0)
    assert code == 0
    assert told["flash_temperature"][k] == pytest.approx(258.9, abs=0.05)
    assert told["flash_width"][k] * 1e6 == pytest.approx(46.60, abs=0.005)
    assert told["slope_length"][k] * 1e6 == pytest.approx(118.0, abs=0.05)
    assert told["heat_partition"][k] == 0.938
    assert told["heat_partition_theory"][k] == pytest.approx(0.9380, abs=5e-5)
    assert told["contact_fraction"] == pytest.approx(0.075, abs=1e-6)
    assert len(told["pressure_correlation"]["r"]) == len(told["pressure_correlation"]["value"])
    assert told["pressure_correlation"]["value"][0] == pytest.approx(4.6165e16, rel=1e-4)
    assert set(told) == {
        "speed",
        "flash_temperature",
        "flash_gradient",
        "flash_laplacian",
        "flash_width",
        "slope_length",
        "conductivity",
        "heat_partition",
        "heat_partition_theory",
        "contact_fraction",
        "plastic_fraction",
        "pressure_correlation",
        "calibrated",
        "scene_facts",
        "scene_statements",
        "scene_warnings",
    }


def test_theory_and_plan_print_tables(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "300")  # no cell is wrapped
    code, out, _ = inside(capsys, "theory", "steel-1.2GPa", "--all")
    assert code == 0
    assert "258.9" in out
    code, out, _ = inside(capsys, "plan", "steel-1.2GPa", "--all")
    assert code == 0
    words = " ".join(out.split())
    assert "to q_c = 1.08e+06 rad/m" in words
    assert "C(q) goes on to 4.15e+07 rad/m" in words
    code, out, _ = inside(capsys, "plan", "steel-1.2GPa", "--json")
    cut_offs = [
        level["q_max"] for level in json.loads(out)["levels"] if level["column"] == "capped"
    ]
    assert max(cut_offs) >= 4 * min(cut_offs)


def test_new_prints_a_scene_to_start_from(capsys, tmp_path):
    code, out, _ = inside(capsys, "new", "demo")
    assert code == 0
    path = tmp_path / "mine.toml"
    path.write_text(out)
    assert inside(capsys, "plan", path)[0] == 0
    code, out, _ = inside(capsys, "new")
    assert out.split() == [*bundled_scenes(), "blank"]


@pytest.mark.slow
def test_run_and_compare_a_scene_of_ones_own(capsys, tmp_path, capped_scene):
    path, folder = tmp_path / "scene.toml", tmp_path / "out"
    path.write_text(capped_scene.to_toml())
    code, _, err = inside(capsys, "run", path, "-o", folder, "--workers", 1, "--max", 3)
    assert code == 0
    assert "3 realizations in" in err
    code, out, err = inside(capsys, "compare", folder, "--json")
    assert json.loads(out)["realizations"] == 3
    code, out, err = inside(capsys, "compare", folder, "--chart", folder / "chart.png")
    assert code == 0
    assert "capped/smoothed at" in out
    assert (folder / "chart.png").exists()
    code, _, err = inside(
        capsys,
        "run",
        path,
        "-o",
        folder,
        "--workers",
        1,
        "--max",
        3,
        "--until",
        "flash_temperature=1%",
    )
    assert "target not reached" in err
    assert "the target of" not in err
    assert code == 0
    code, _, err = inside(
        capsys,
        "run",
        path,
        "-o",
        folder,
        "--workers",
        1,
        "--max",
        3,
        "--until",
        "flash_temperature=90%",
    )
    assert "the target of flash_temperature was 1 %, and is 90 % now" in err
    assert "--until flash_temperature=1% takes them in again" in err
    code, _, err = inside(capsys, "theory", folder)
    assert err.endswith(f"give the path of a file; {folder}/scene.toml is the scene of this run\n")


@pytest.mark.slow
def test_the_demo_ends_with_a_picture(capsys, tmp_path):
    code, out, err = inside(capsys, "demo", "-o", tmp_path / "demo", "--workers", "1")
    assert code == 0
    assert "flash_temperature, K" in out
    assert max(map(len, out.splitlines()[1:5])) <= 80  # the table
    assert (tmp_path / "demo" / "comparison.png").stat().st_size > 10_000
    assert "12 realizations" in err


WRONG_KEY = "--set", "sliding.speeds=2m/s"
WRONG = {
    "no such scene": (("theory", "steal-1.2GPa"), "steel-1.2GPa"),
    "no such file": (("plan", "missing.toml"), "missing.toml"),
    "no such run": (("compare", "missing"), "missing does not exist; start it with"),
    "bad target": (
        ("run", "demo", "-o", "{tmp}/a", "--until", "flash_temperature=lots"),
        'lots" is not a number with a unit; write for example "1 %"',
    ),
    "bad total target": (
        ("plan", "demo", "--target-error", "120%"),
        '--target-error = "120%" must be less than 1',
    ),
    "unknown observable": (
        ("run", "demo", "-o", "{tmp}/a", "--until", "heat=1%"),
        "ensemble.until.heat is not an observable; ",
    ),
    "file in the way": (("run", "demo", "-o", "{tmp}/file"), "is a file; name a new folder"),
    "scene of somebody": (
        ("run", "demo", "-o", "{tmp}"),
        "holds other files; name a new folder for the run",
    ),
    **{
        f"picture of {verb}": ((verb, scene, "--chart", "a.gif"), "must end in .png, .pdf, .svg")
        for verb, scene in (("theory", "demo"), ("bench", "demo"), ("compare", "no-run"))
    },
    **{
        f"key of {verb}": ((verb, "demo", *WRONG_KEY), 'did you mean "speed"?')
        for verb in ("theory", "plan", "bench")
    },
    "key of run": (("run", "demo", "-o", "{tmp}/a", *WRONG_KEY), 'did you mean "speed"?'),
}


@pytest.mark.parametrize("name", WRONG)
def test_errors_are_one_line(capsys, tmp_path, name):
    words, message = WRONG[name]
    (tmp_path / "file").write_text("x")
    (tmp_path / "scene.toml").write_text("this is [ no toml")
    code, out, err = inside(capsys, *(str(word).format(tmp=tmp_path) for word in words))
    assert code == 1
    assert out == ""
    lines = [
        line
        for line in err.strip().splitlines()
        if " × " not in line and line != "roughsim: planning demo"
    ]  # the plan may have been shown
    assert len(lines) == 1
    assert lines[0].startswith("roughsim: ")
    assert message in lines[0]
    assert {path.name for path in tmp_path.iterdir()} == {"file", "scene.toml"}


def test_help_helps(capsys):
    out, _ = call("--help")
    for verb in ("demo", "new", "plan", "theory", "run", "compare", "plot", "export"):
        assert verb in out
    _, out, _ = inside(capsys, "compare", "--help")
    assert "Folders of runs, or of a study." in " ".join(out.split())
    _, out, _ = inside(capsys, "--version")
    assert out.startswith("roughsim ")


def test_the_list_of_verbs_cuts_no_sentence_on_a_terminal_of_80_columns(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    code, out, _ = inside(capsys, "--help")
    assert code == 0
    verbs = out.partition("Commands:\n")[2].splitlines()
    assert [line.split()[0] for line in verbs] == [
        info.name or info.callback.__name__ for info in cli.app.registered_commands
    ]
    assert all(line.endswith(".") and not line.endswith("...") for line in verbs)


@pytest.mark.parametrize("words", [("theory", "nosuch"), ("doctor",)])
def test_lines_break_between_words_of_a_terminal(capsys, monkeypatch, words):
    monkeypatch.setenv("COLUMNS", "200")
    _, out, err = inside(capsys, *words)
    monkeypatch.setenv("COLUMNS", "60")
    assert inside(capsys, *words)[2] == err  # of a pipe
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    _, *narrow = inside(capsys, *words)
    assert max(map(len, (out + err).splitlines())) > 60
    for line in "".join(narrow).splitlines():
        assert len(line) <= 60 or " " not in line
    if words == ("theory", "nosuch"):
        assert " ".join("".join(narrow).split()) == err.strip()


def test_the_readme_lists_the_verbs_that_there_are():
    readme = (ROOT / "README.md").read_text()
    verbs = {info.name or info.callback.__name__ for info in cli.app.registered_commands}
    assert set(re.findall(r"^\| `roughsim (\w+)", readme, re.MULTILINE)) == verbs


def test_a_run_ends_with_its_comparison_and_its_picture(capsys, tmp_path, quick, drawn):
    path, folder, picture = tmp_path / "scene.toml", tmp_path / "run", tmp_path / "run.svg"
    path.write_text(quick.to_toml())
    words = ("run", path, "-o", folder, "--workers", 1, "--max")
    code, out, err = inside(capsys, *words, 1)
    assert (code, out) == (0, "")
    assert "not compared: " in err
    about = (
        r"\w+ contact, up to \d+ × \d+ points, of max_realizations = 1.*; about .* s of CPU time"
    )
    assert re.search(about, " ".join(err.split()))
    code, out, err = inside(capsys, *words, 3, "--chart", picture)
    assert code == 0
    assert f"picture: {picture}" in err
    assert len(drawn) == 1
    _, compared, _ = inside(capsys, "compare", folder)
    assert compared.startswith(out)
    assert "realizations; flash_temperature, K" in out
    code, out, err = inside(capsys, *words, 3, "--chart", tmp_path / "run.txt")
    assert code == 1
    assert "must end in .png, .pdf, .svg" in err


def test_too_many_failures_make_the_exit_code_tell(capsys, tmp_path, quick, failing):
    failing(lambda problem: problem.index == 1)
    (tmp_path / "scene.toml").write_text(quick.to_toml())
    words = ("run", tmp_path / "scene.toml", "-o", tmp_path / "run", "--workers", 1, "--max", 3)
    code, _, err = inside(capsys, *words)
    assert code == 1
    assert "1 did not converge and are left out of the means" in err
    code, out, _ = inside(capsys, "status", tmp_path / "run", "--json")
    told = json.loads(out)
    assert (told["realizations"], told["failed"], told["writer"]) == (3, 1, None)
    assert len(told["estimates"]["flash_temperature"]["mean"]) == 3
    code, out, _ = inside(capsys, "status", tmp_path / "run")
    assert code == 0
    assert "1 did not converge" in out


def test_an_interrupt_says_that_nothing_is_lost(capsys, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("roughsim.ensemble.run.complete", interrupted)
    code, _, err = inside(capsys, "run", "demo", "-o", tmp_path / "run")
    assert code == 130
    assert err.splitlines()[-1].startswith("roughsim: stopped; all finished members are stored")


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("roughsim plan st", ["steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa"]),
        ("roughsim run g", ["granite"]),
        ("roughsim new b", ["blank"]),
        ("roughsim plan runs/mine", []),  # the shell itself then completes the path
        ("roughsim doct", ["doctor"]),
    ],
)
@pytest.mark.slow
def test_the_shell_completes_verbs_and_scenes(typed, offered):
    code = "import sys; sys.argv = ['roughsim']; from roughsim.cli import main; main()"
    asked = {
        "_ROUGHSIM_COMPLETE": "complete_bash",
        "COMP_WORDS": typed,
        "COMP_CWORD": str(typed.count(" ")),
    }
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **asked},
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=False,
    )
    assert done.stdout.split() == offered
    assert done.stderr == ""


def test_help_loads_nothing_heavy():
    code = (
        "import sys; from roughsim import cli\n"
        "try: cli.main(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'scipy', 'numba', 'h5py', 'matplotlib', 'pydantic', 'pint', 'pyfftw', 'rich'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert found.stdout.splitlines()[-1] == "[]"


def test_a_warning_is_one_line_without_the_place_in_the_code(capsys, theory_table, tmp_path):
    import warnings

    def warned(scene):
        warnings.warn("the cell\nis small", RuntimeWarning, stacklevel=1)
        return ""

    theory_table(warned)
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        code, _, err = inside(capsys, "theory", "demo", "--all")
    assert code == 0
    assert err == "roughsim: warning: the cell is small\n"


def test_too_little_memory_is_said_in_one_line(capsys, theory_table):
    def greedy(scene):
        raise MemoryError("Unable to allocate 512. TiB")

    theory_table(greedy)
    code, out, err = inside(capsys, "theory", "demo")
    assert (code, out) == (1, "")
    assert err.startswith(
        "roughsim: out of memory (Unable to allocate 512. TiB); lower numerics.levels"
    )
    assert err.count("\n") == 1


def test_the_command_line_sets_keys(capsys):
    _, slower, _ = inside(capsys, "theory", "demo", "--set", "sliding.speed=2m/s", "--json")
    assert json.loads(slower)["speed"] == [2.0]
