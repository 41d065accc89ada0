"""What the command line does with streams that lack letters, are closed or end early, and with odd files."""

import io
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest

from roughsim import cli
from roughsim.scene import bundled_scenes, parse_scene, scene_text

ROOT = Path(__file__).parents[1]
ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


def started(*words, environment=None, **streams):
    return subprocess.run(
        [sys.executable, "-m", "roughsim", *map(str, words)],
        env=os.environ | (environment or {}),
        cwd=ROOT,
        check=False,
        timeout=120,
        **streams,
    )


@pytest.fixture
def in_ascii():
    """Runs a command whose streams know ASCII alone; returns what was written."""

    def call(*words):
        streams = [io.TextIOWrapper(io.BytesIO(), encoding="ascii") for _ in range(2)]
        words = [str(word) for word in words]
        out, err = streams
        with redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as ended:
            cli.main(words)
        assert ended.value.code in (None, 0)
        for stream in streams:
            stream.flush()
        return "".join(stream.buffer.getvalue().decode("ascii") for stream in streams)

    return call


def test_a_stream_of_ascii_gets_words_for_what_it_lacks(in_ascii, capped_run):
    assert " +/- " in in_ascii("compare", capped_run.folder)
    assert {"um", "K/um^2"} <= set(
        in_ascii("theory", capped_run.folder / "scene.toml", "--all").split()
    )


def test_scenes_printed_in_ascii_are_the_same_scenes(in_ascii):
    for name in bundled_scenes():
        assert parse_scene(in_ascii("new", name)) == parse_scene(scene_text(name))


@pytest.mark.slow
@pytest.mark.parametrize("environment", [ASCII, {"PYTHONIOENCODING": "latin-1"}])
def test_no_language_of_the_machine_ends_in_a_traceback(environment, tmp_path, capped_run):
    scene = tmp_path / "größe.toml"
    scene.write_text(
        scene_text("demo").replace('title = "', 'title = "Größe ± 漢字 ∇ '), encoding="utf-8"
    )
    for words in (("theory", scene), ("status", capped_run.folder)):
        done = started(*words, environment=environment, capture_output=True)
        assert done.returncode == 0, done.stderr
        assert b"Traceback" not in done.stderr


@pytest.mark.slow
def test_a_reader_that_leaves_or_a_full_disk_is_no_traceback(capped_run):
    words = f"{sys.executable} -m roughsim status {capped_run.folder}"
    environment = os.environ | {"PYTHONUNBUFFERED": ""}  # what buffers hold is written at the end
    for tail in ("| head -1", ">&-", "2>&-", "> /dev/full", "2> /dev/full"):
        shell = ["sh", "-c", f"{words} {tail}"]
        done = subprocess.run(
            shell, capture_output=True, text=True, cwd=ROOT, env=environment, check=False
        )
        assert "Traceback" not in done.stderr, tail
        assert "Exception ignored" not in done.stderr, tail
        assert done.stderr.count("\n") <= 1


@pytest.fixture
def odd_files(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "latin.toml").write_bytes(b'title = "\xff"\n')
    (tmp_path / "nul.toml").write_bytes(b'title = "\x00"\n')
    return tmp_path


ODD = {
    "pipe.toml": "pipe.toml is a folder or a device",
    "folder.toml": "folder.toml is a folder or a device",
    "latin.toml": "latin.toml is not UTF-8 text (byte 9)",
    "nul.toml": "nul.toml: not valid TOML",
    "/dev/zero": "/dev/zero is a folder or a device",
    "x" * 5000 + ".toml": "cannot be read (File name too long)",
    "missing\udcff.toml": "missing?.toml does not exist",
}


@pytest.mark.parametrize("name", ODD)
@pytest.mark.parametrize("verb", ["plan", "theory"])
def test_an_odd_file_for_a_scene_is_one_line_that_names_it(odd_files, capsys, verb, name):
    with pytest.raises(SystemExit) as ended:
        cli.main([verb, str(odd_files / name)])
    error = capsys.readouterr().err
    assert ended.value.code == 1
    assert ODD[name] in error
    assert error.count("\n") == 1
    assert len(error) < 2000
