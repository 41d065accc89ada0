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


def test_a_missing_extra_says_the_pip_line(capped_run, capsys, without):
    without("bokeh")
    assert "pip install 'roughsim[explore]'" in refused([str(capped_run.folder)], capsys)


def test_a_folder_that_is_no_run_is_refused(tmp_path, capsys):
    pytest.importorskip("bokeh")
    assert f"{tmp_path} is no run" in refused([str(tmp_path), "--no-browser"], capsys)
    assert "does not exist" in refused([str(tmp_path / "none"), "--no-browser"], capsys)
