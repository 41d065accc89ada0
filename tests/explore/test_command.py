"""The command `explore`: what it needs, and what it refuses."""

import subprocess
import sys
from pathlib import Path

import pytest

import roughsim as rs
from roughsim.cli import main


def refused(words_, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["explore", *words_])
    assert ended.value.code == 1
    error = capsys.readouterr().err
    assert error.startswith("roughsim: ")
    assert error.count("\n") == 1
    return error


def test_the_help_never_imports_bokeh():
    code = (
        "import sys; from roughsim.cli import main\n"
        "for words in (['--help'], ['explore', '--help']):\n"
        "    try: main(words)\n"
        "    except SystemExit: pass\n"
        "print({'bokeh', 'tornado', 'numpy'} & set(sys.modules))"
    )
    root = str(Path(rs.__file__).parents[1])
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root
    )
    assert "--no-browser" in done.stdout
    assert done.stdout.endswith("set()\n")


REFUSED = {
    "is no run": "{tmp}",
    "does not exist": "{tmp}/none",
    "pip install 'roughsim[explore]'": "{run}",  # without bokeh
}


@pytest.mark.parametrize("words", REFUSED)
def test_explore_is_refused_in_one_line(words, capped_run, tmp_path, capsys, without):
    without("bokeh") if "pip" in words else pytest.importorskip("bokeh")
    folder = REFUSED[words].format(tmp=tmp_path, run=capped_run.folder)
    assert words in refused([folder, "--no-browser"], capsys)
