"""A small run with kept fields, and its exported file."""

from dataclasses import replace

import pytest

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
