"""The version is the tag's, in all places, and archives say what the citation says."""

import json
import re
import subprocess
import tomllib
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest

import roughsim

ROOT = Path(__file__).parents[1]


def tags():
    """The version tags of this very commit."""
    words = ["git", "tag", "--points-at", "HEAD", "--list", "v*"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout.split()


def test_the_package_says_the_version_that_it_was_built_with():
    assert roughsim.__version__ == version("roughsim")
    assert re.match(r"\d+\.\d+", roughsim.__version__)


def test_copies_without_git_are_older_than_the_cited_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    cited = re.search(r"^version: (.*)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    assert re.fullmatch(r"\d+\.\d+\.\d+(rc\d+)?", cited.group(1))
    fallback = project["tool"]["setuptools_scm"]["fallback_version"]
    assert fallback == f"{cited.group(1)}.dev0"  # below the release: 0.1.0.dev12 without a tag


def test_the_archive_has_the_title_and_the_keywords_of_the_citation():
    archive = json.loads((ROOT / ".zenodo.json").read_text())
    citation = (ROOT / "CITATION.cff").read_text()
    assert f'title: "{archive["title"]}"' in citation
    assert re.findall(r"^  - (\w[^:\n]*)$", citation, re.MULTILINE) == archive["keywords"]


def test_a_package_that_was_never_built_says_so(monkeypatch):
    def missing(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr("importlib.metadata.version", missing)
    assert roughsim.__version__ == "0+unknown"


def test_a_tagged_commit_has_its_version_in_the_citation_and_the_changes():
    found = tags()
    if not found:
        pytest.skip("this commit has no version tag")
    assert len(found) == 1
    release = found[0].removeprefix("v")
    assert f"\nversion: {release}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"## [{release}] - " in (ROOT / "CHANGELOG.md").read_text()
