"""Small runs: one with kept fields and its exported file, and one of many realizations on two levels."""

import shutil
from dataclasses import replace

import pytest
from stored_cases import split_members
from summary_cases import COUNT

import roughsim as rs
from roughsim.results.export import export_run


@pytest.fixture(scope="package")
def kept_run(capped_scene, tmp_path_factory):
    """Three realizations, the fields of two kept."""
    scene = replace(capped_scene, numerics=replace(capped_scene.numerics, keep_fields=2))
    return rs.run(scene, tmp_path_factory.mktemp("runs") / "kept", max_realizations=3)


@pytest.fixture(scope="package")
def file(kept_run, tmp_path_factory):
    return export_run(kept_run, tmp_path_factory.mktemp("files") / "new" / "kept.h5")


@pytest.fixture(scope="package")
def whole(capped_scene, tmp_path_factory):
    """A run of two levels."""
    levels = (
        {"column": "capped", "shape": [32, 32], "q_max": 2.5e4},
        {"column": "capped", "shape": [32, 32], "q_max": 4e4},
    )
    scene = replace(
        capped_scene, numerics=replace(capped_scene.numerics, levels=levels, keep_fields=1)
    )
    run = rs.run(scene, tmp_path_factory.mktemp("whole") / "run", max_realizations=COUNT)
    split_members(run.folder)
    return run


@pytest.fixture
def folder(whole, tmp_path):
    """A copy of the folder of `whole`."""
    return shutil.copytree(whole.folder, tmp_path / "run")
