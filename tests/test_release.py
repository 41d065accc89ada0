"""One version in all places, and the tag's."""

import re
import subprocess
from importlib.metadata import version
from pathlib import Path

import pytest

import roughsim

ROOT = Path(__file__).parents[1]


def tags():
    """The version tags of this very commit."""
    words = ["git", "tag", "--points-at", "HEAD", "--list", "v*"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout.split()


def test_the_version_is_a_semantic_one_and_the_citation_has_it():
    assert re.fullmatch(r"\d+\.\d+\.\d+(\.dev\d+|rc\d+)?", roughsim.__version__)
    cited = re.search(r"^version: (.*)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    assert cited.group(1) == roughsim.__version__


def test_the_installed_package_says_the_same_version():
    assert version("roughsim") == roughsim.__version__


def test_a_tagged_commit_has_the_version_of_its_tag_and_its_changes():
    found = tags()
    if not found:
        pytest.skip("this commit has no version tag")
    assert found == [f"v{roughsim.__version__}"]
    assert f"## [{roughsim.__version__}] - " in (ROOT / "CHANGELOG.md").read_text()
