"""The doctor: a sound installation passes two exact cases; whatever is broken is told, and the exit code says so."""

import importlib
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import roughsim as rs
from roughsim import cli
from roughsim.cli import installation as doctor
from roughsim.store.claims import Claims, process_space


def told(capsys, *words):
    with pytest.raises(SystemExit) as ended:
        cli.main(["doctor", *words])
    return ended.value.code, capsys.readouterr().out


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return doctor.examine(tmp_path_factory.mktemp("empty"))


def test_a_sound_installation_computes_two_exact_cases(found):
    assert found["sound"]
    assert [check["name"] for check in found["checks"]] == ["contact", "heat"]
    assert all(
        abs(check["error"]) < limit
        for check, limit in zip(found["checks"], (5e-3, 1e-9), strict=True)
    )
    assert found["packages"]["numpy"]["version"] == np.__version__
    assert found["fft"] == rs.fourier.backend()
    assert found["cores"] >= 1
    assert found["memory_bytes"] > 1e8
    assert found["claims"] == []
    assert doctor.lines(found)[-1] == "all is well"
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_a_solver_that_is_off_by_a_percent_is_found_out(monkeypatch, capsys):
    genuine = rs.sliding_temperature
    home = importlib.import_module(genuine.__module__)
    monkeypatch.setattr(home, "sliding_temperature", lambda *a, **k: 1.01 * genuine(*a, **k))
    code, out = told(capsys, "--json")
    checks = {check["name"]: check for check in json.loads(out)["checks"]}
    assert code == 1
    assert not checks["heat"]["sound"]
    assert checks["heat"]["error"] == pytest.approx(0.01)
    assert checks["contact"]["sound"]
    code, out = told(capsys)
    assert code == 1
    assert "WRONG: temperature of a resting wave" in out
    assert out.strip().endswith("something is wrong: see the lines above")


@pytest.mark.slow
def test_what_breaks_altogether_is_told_in_one_line(tmp_path):
    # a package that cannot be imported stands before the sound one
    (tmp_path / "scipy").mkdir()
    (tmp_path / "scipy" / "__init__.py").write_text(
        'raise ImportError("libopenblas.so.0:\\ncannot open")'
    )
    places = os.pathsep.join([str(tmp_path), str(Path(rs.__file__).parents[1])])
    words = [sys.executable, "-m", "roughsim", "doctor", "--json"]
    ended = subprocess.run(
        words,
        env={**os.environ, "PYTHONPATH": places},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    found = json.loads(ended.stdout)
    assert ended.returncode == 1
    assert not found["sound"]
    assert found["checks"][0]["says"] == "failed, ImportError: libopenblas.so.0: cannot open"
    assert found["fft"] is None


def test_missing_and_old_packages_come_with_the_line_that_installs_them(install, tmp_path):
    needs = (
        "numpy>=999",
        "no-such-package>=1.2",
        "rich",
        'also-none>=3; extra == "sky"',
        'rich>=1; extra == "earth"',
    )
    install("roughsim", (*needs, 'pytest>=8; extra == "test"'))
    found = doctor.examine(tmp_path)
    lines = doctor.lines(found)
    assert not found["sound"]
    assert f"packages: numpy {np.__version__}, no-such-package missing" in lines[2]
    assert "numpy is needed as numpy>=999: pip install 'numpy>=999'" in lines
    assert (
        "no-such-package is needed as no-such-package>=1.2: pip install 'no-such-package>=1.2'"
        in lines
    )
    assert "extra sky: lacks also-none>=3: pip install 'also-none>=3'" in lines
    assert "extra earth: complete" in lines
    assert set(found["extras"]) == {"sky", "earth"}  # what only developers need is not missed


def test_missing_pyfftw_is_told_and_does_without(install, tmp_path):
    install("roughsim", ["pyfftw>=999"])
    found = doctor.examine(tmp_path)
    assert found["sound"]
    assert any("pyfftw>=999" in line for line in doctor.lines(found))


def test_runs_below_are_named_with_who_computes_them_or_who_is_gone(soon, tmp_path):
    for name in ("one", "deep/two", "other"):
        (tmp_path / name / "claims").mkdir(parents=True)
        if name != "other":
            (tmp_path / name / "run.json").write_text("{}")
    (tmp_path / "deep" / "two" / "claims" / "process-here-1").write_text(
        f"0\nhere {2**22 + 1} {process_space()}\n"
    )
    with Claims(tmp_path / "one"):
        found = {os.path.basename(one["folder"]): one for one in doctor.examine(tmp_path)["claims"]}
    assert set(found) == {"one", "two"}
    assert str(os.getpid()) in found["one"]["writer"]
    assert found["two"]["writer"] is None
    assert "run the scene again to go on" in found["two"]["says"]
