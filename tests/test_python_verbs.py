"""The verbs from Python: the functions of the command line, by name, path or record."""

import json
from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs


@pytest.fixture(scope="module")
def contact():
    """A contact of two waves, whose load leaves gaps."""
    grid = rs.Grid((32, 32), (1e-3, 1e-3))
    x = np.arange(32) / 32
    heights = 1e-6 * np.cos(2 * np.pi * x)[:, None] * np.cos(2 * np.pi * x)[None, :]
    return rs.solve_contact(heights, grid, rs.Solid(1e11, 1e9), nominal_pressure=1e7)


SOURCE = rs.HeatSource(
    speeds=[1.0, 35.0], friction_coefficient=0.1, conductivity=30.0, diffusivity=7.6e-6
)


def test_a_contact_knows_its_grid_and_solid(contact):
    assert contact.grid == rs.Grid((32, 32), (1e-3, 1e-3))
    assert contact.solid == rs.Solid(1e11, 1e9)


def test_a_contact_is_measured_on_its_own_grid(contact):
    short = rs.measure(contact, SOURCE)
    # a cell of twice the side has waves of twice the length: T ∝ 1/q at rest
    longer = rs.measure(contact, rs.Grid((32, 32), (2e-3, 2e-3)), SOURCE)
    assert short.resting_flash_temperature == pytest.approx(
        longer.resting_flash_temperature / 2, rel=1e-12
    )


def test_a_contact_without_grid_needs_one(contact):
    bare = replace(contact, grid=None, solid=None)
    with pytest.raises(
        TypeError, match=r"contact has no grid; write measure\(contact, grid, heat_source\)"
    ):
        rs.measure(bare, SOURCE)
    with pytest.raises(TypeError, match="measure needs a HeatSource"):
        rs.measure(contact, contact.grid)


def test_records_show_themselves_in_one_line(contact):
    assert repr(contact).startswith("<Contact on 32 × 32 points: contact_fraction 0.")
    moments = rs.measure(contact, SOURCE)
    assert (
        f"T_flash {moments.flash_temperature[0]:.4g}, {moments.flash_temperature[1]:.4g} K"
        in repr(moments)
    )
    assert "\n" not in repr(contact) + repr(moments)


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_verbs_take_a_name_a_path_or_a_record(capped_run, tmp_path):
    assert rs.theory("steel-1.2GPa").flash_temperature[5] == pytest.approx(
        258.9, abs=0.05
    )  # 35 m/s
    hot = rs.theory("steel-1.2GPa", changes={"sliding.friction_coefficient": 0.22})
    assert hot.flash_temperature == pytest.approx(
        2 * rs.theory("steel-1.2GPa").flash_temperature, rel=1e-12
    )
    scene = rs.load_scene("steel-1.2GPa")
    hot = rs.theory(scene, changes={"sliding.friction_coefficient": 0.22})
    assert hot.flash_temperature == pytest.approx(2 * rs.theory(scene).flash_temperature, rel=1e-12)
    assert str(rs.compare(str(capped_run.folder))) == str(rs.compare(capped_run))
    summary = rs.compare(capped_run).summary()
    assert len(summary.rows) == len(capped_run.scene.speeds)
    for k, row in enumerate(summary.rows):
        assert str(row[-1]) == str(capped_run.estimate("flash_temperature", "capped").number(k))
    assert rs.status(capped_run.folder).to_dict() == rs.status(capped_run).to_dict()
    assert rs.status(capped_run).to_dict()["realizations"] == capped_run.realizations
    assert "finished" in str(rs.status(capped_run))
    page = rs.report(capped_run.folder, tmp_path / "a.html")
    assert page.read_text().startswith("<!DOCTYPE html>")
    with pytest.raises(TypeError, match="must be a run, a study, or the path of a folder"):
        rs.compare(3.0)


def test_every_verb_stays_a_function(capped_run):
    # modules of the same name would take its place once they are imported
    for name in (
        "theory",
        "plan",
        "run",
        "press",
        "study",
        "status",
        "compare",
        "plot",
        "report",
        "export",
        "bench",
    ):
        for _ in range(2):
            assert callable(getattr(rs, name))

    assert callable(rs.report)
    with pytest.raises(AttributeError, match="from theory import flash"):
        rs.theory.flash  # noqa: B018
    with pytest.warns(rs.SceneWarning) as given:
        rs.theory("granite")
    assert given[0].filename == __file__


def test_a_scene_to_start_from_is_the_bundled_text(tmp_path):
    assert "steel-1.2GPa" in rs.new().split()
    assert rs.new("demo", tmp_path / "my.toml") == (tmp_path / "my.toml").read_text()
    assert rs.load_scene(tmp_path / "my.toml") == rs.load_scene("demo")
    with pytest.raises(FileExistsError):
        rs.new("demo", tmp_path / "my.toml")


def test_the_exported_table_has_each_mean_with_its_error(capped_run, tmp_path):
    rows = json.loads(rs.export(capped_run, tmp_path / "a.json").read_text())["rows"]
    for name in ("flash_temperature", "contact_fraction"):
        estimate = capped_run.estimate(name, "capped")
        found = [row for row in rows if (row["observable"], row["column"]) == (name, "capped")]
        assert [row["value"] for row in found] == pytest.approx(estimate.mean, rel=1e-12)
        assert [row["total_error"] for row in found] == pytest.approx(
            estimate.total_error, rel=1e-12
        )
    for path, options in (
        ("a.csv", {"bits": 8}),
        ("a.h5", {"bits": 8, "surface": 0}),
        ("a.txt", {}),
    ):
        with pytest.raises(
            ValueError, match=r"bits is for fields|bits does not go with|must end in"
        ):
            rs.export(capped_run, tmp_path / path, **options)
