"""Files and names of scenes, and files that are none."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from steel_text import STEEL

from roughsim.scene import SceneError, bundled_scenes, load_scene, scene_text


def test_a_misspelt_name_gets_the_nearest_and_the_list():
    with pytest.raises(SceneError) as caught:
        load_scene("steel-1.2Gpa")
    assert 'did you mean "steel-1.2GPa"?' in str(caught.value)
    assert all(name in str(caught.value) for name in bundled_scenes())
    with pytest.raises(SceneError, match="did you mean"):
        scene_text("dmeo")


def test_files_that_are_no_scene_are_refused_in_one_line(tmp_path):
    binary, big, exact = tmp_path / "b.toml", tmp_path / "big.toml", tmp_path / "exact.toml"
    binary.write_bytes(bytes(range(256)))
    big.write_text(STEEL + "#" * (64 * 1024 + 1 - len(STEEL.encode())))
    exact.write_text(STEEL + "#" * (64 * 1024 - len(STEEL.encode())))
    assert load_scene(exact) == load_scene("steel-1.2GPa")
    for path, words in [
        (binary, "not UTF-8"),
        (big, "64 KiB"),
        (tmp_path, "is a folder"),
        ("a\0.toml", ""),
    ]:
        with pytest.raises((SceneError, FileNotFoundError)) as caught:
            load_scene(path)
        assert words in str(caught.value)
        assert str(caught.value).isprintable()
    with pytest.raises(
        FileNotFoundError, match=r'steel-1\.2\.toml does not exist.*"steel-1\.2GPa"'
    ):
        load_scene(tmp_path / "steel-1.2.toml")
    with pytest.raises(TypeError, match="name_or_path = 3"):
        load_scene(3)  # type: ignore[arg-type]


@pytest.mark.skipif(os.name != "posix", reason="named pipes")
def test_a_pipe_is_refused_rather_than_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(SceneError, match="folder or a device"):
        load_scene(tmp_path / "pipe.toml")


def test_windows_line_ends_and_byte_order_marks_do_not_matter(tmp_path, steel):
    path = tmp_path / "s.toml"
    path.write_bytes(b"\xef\xbb\xbf" + STEEL.replace("\n", "\r\n").encode())
    assert load_scene(str(path)) == steel


@pytest.mark.slow
def test_bundled_scenes_are_read_without_pint():
    code = "import sys, roughsim as rs; from roughsim.scene import bundled_scenes as all_of\n"
    code += "for name in all_of(): rs.load_scene(name)\nsys.exit('pint' in sys.modules)"
    assert (
        subprocess.run(
            [sys.executable, "-c", code], check=False, cwd=Path(__file__).parents[2]
        ).returncode
        == 0
    )


def test_importing_the_package_reads_no_scene_module():
    code = "import sys, roughsim; sys.exit(any(m in sys.modules for m in ('pydantic', 'pint', 'roughsim.scene')))"
    assert (
        subprocess.run(
            [sys.executable, "-c", code], check=False, cwd=Path(__file__).parents[2]
        ).returncode
        == 0
    )
