"""A spectrum, a solver and an observable are one new file each: those of docs/examples.

They run as a package of their own, installed with the entry points of its pyproject.toml: roughsim is not edited.
"""

import json
import os
import re
import runpy
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from roughsim.observables import catalogue

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "docs" / "examples"
SCENE = (EXAMPLES / "own.toml").read_text()
ENTRY_POINTS = tomllib.loads((EXAMPLES / "pyproject.toml").read_text())["project"]["entry-points"]
MODULES = {place.partition(":")[0] for group in ENTRY_POINTS.values() for place in group.values()}
FILES = {f"{name}.py": (EXAMPLES / f"{name}.py").read_text() for name in sorted(MODULES)}
SCRIPT = """
import dataclasses, json
from pathlib import Path
import h5py, roughsim as rs
from roughsim.results.export import export_run
from roughsim.outputs.run_report import errors_section
from roughsim.show.markup import html_table
from roughsim.show.table import table_text

scene = rs.load_scene("own.toml")
Path("again.toml").write_text(scene.to_toml())
assert rs.load_scene("again.toml") == scene
run = rs.run(scene, "out")
found = rs.open_run("out").estimate("stress_length")
table = rs.compare(rs.open_run("out"))
Path("table.txt").write_text(table_text(table.table()))
Path("report.html").write_text(errors_section(run) + html_table(table.table()))
export_run(run, "out.h5")
with h5py.File("out.h5") as file:
    stored = file["members/pressure_variance_over_q"]
    exported = [stored.shape[1:], stored.attrs["units"], stored.attrs["description"]]
one = rs.realize(scene, run.numerics, seed=1).observables
plain = rs.realize(scene, dataclasses.replace(run.numerics, solver="active_set", tolerance=1e-8), seed=1).observables
pressed = rs.load_scene("pressed.toml")
full = rs.compare(rs.run(pressed, "full"))
print(json.dumps({
    "home": rs.__file__, "solver": run.numerics.solver, "identity": scene.identity(), "met": run.target_met,
    "mean": found.mean.tolist(), "unit": found.unit, "n": found.n, "error": found.half_width.tolist(),
    "full": full.to_dict()["rows"], "rows": table.to_dict()["rows"], "exported": exported,
    "temperature": one.flash_temperature.tolist(), "plain": plain.flash_temperature.tolist(),
}))
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """What a run of the example scene gives, from scene to report, with the three files installed."""
    home = tmp_path_factory.mktemp("own")
    installed = home / "own-1.0.dist-info"  # what pip leaves of a package with these entry points
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: own\nVersion: 1.0\n")
    groups = [(group, entry) for group, names in ENTRY_POINTS.items() for entry in names.items()]
    text = "".join(f"[{group}]\n{name} = {function}\n" for group, (name, function) in groups)
    (installed / "entry_points.txt").write_text(text)
    for name, text in FILES.items():
        (home / name).write_text(text)
    (home / "own.toml").write_text(SCENE)
    pressed = {"2e-22": "2e-26", "= 12": "= 2", "1e-3": "1e-9"}
    (home / "pressed.toml").write_text(
        re.sub("|".join(pressed), lambda found: pressed[found[0]], SCENE)
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(home), str(ROOT)])}
    words = [sys.executable, "-c", SCRIPT]
    done = subprocess.run(
        words, cwd=home, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert Path(found["home"]).parent == ROOT / "roughsim"
    return found | {"folder": home}


def of_length(rows):
    """The row of the new observable."""
    (row,) = [row for row in rows if row["observable"] == "stress_length"]
    return row


def test_the_page_shows_one_file_and_one_entry_point_for_each():
    assert [*FILES] == ["bump.py", "gradient.py", "stress_length.py"]
    assert [*ENTRY_POINTS] == ["roughsim.spectra", "roughsim.solvers", "roughsim.observables"]
    shown = re.findall(
        r"literalinclude} \.\./examples/(\S+)", (ROOT / "docs" / "how-to" / "extend.md").read_text()
    )
    assert sorted(shown) == sorted([*FILES, "own.toml", "pyproject.toml"])


def test_an_observable_from_outside_may_not_take_the_name_of_another(install):
    def outside(name):
        module = f"records_of_{name}"
        source = f'from roughsim.observables.record import Observable\nRECORDS = (Observable("{name}", "m"),)\n'
        install(
            "others",
            entry_points={"roughsim.observables": {"own": f"{module}:RECORDS"}},
            modules={module: source},
        )
        return runpy.run_path(catalogue.__file__)

    assert [*outside("own")["OBSERVABLES"]] == [*catalogue.OBSERVABLES, "own"]
    with pytest.raises(
        ValueError, match="'flash_width' is defined twice; rename the one of your package"
    ):
        outside("flash_width")


@pytest.mark.slow
def test_a_new_spectrum_is_named_in_a_scene_with_its_own_keys(results):
    given = results["identity"]["surface.spectrum"]
    assert given == {
        "name": "bump",
        "psd_at_q_min": 2e-22,
        "q_min": 6.2e3,
        "q_bump": 3e4,
        "q_max": 6e4,
    }


@pytest.mark.slow
def test_a_new_solver_is_named_in_a_scene_and_agrees_with_the_package_s_own(results):
    assert results["solver"] == "gradient"
    np.testing.assert_allclose(results["temperature"], results["plain"], rtol=1e-3)
    assert results["temperature"] != results["plain"]


@pytest.mark.slow
def test_a_new_observable_is_in_estimates_comparisons_tables_reports_and_files(results):
    assert results["met"]
    assert (results["unit"], results["n"]) == ("m", 12)
    assert 0.0 < results["error"][0] < 0.2 * results["mean"][0]
    names = [one["observable"] for one in results["rows"] if one["speed"] in (None, 35.0)]
    shown = [name for name, record in catalogue.OBSERVABLES.items() if not record.asked]
    assert [name for name in names if name != "stress_length"] == shown
    assert names.index("stress_length") >= 12  # after the package's own
    row = of_length(results["rows"])
    assert row["speed"] is None
    assert row["elastic"]["mean"] == results["mean"][0]
    ratio = row["elastic"]["mean"] / row["theory_same_modes"]
    assert row["elastic_over_theory"]["value"] == pytest.approx(ratio, rel=1e-12)
    assert results["exported"] == [[12], "Pa^2 m", "sum of |sigma(q)|^2/q"]
    assert "stress_length" in (results["folder"] / "table.txt").read_text()
    assert "stress_length, µm" in (results["folder"] / "report.html").read_text()


@pytest.mark.slow
def test_in_full_contact_the_theory_of_a_new_observable_is_exact(results):
    pressed, rough = of_length(results["full"]), of_length(results["rows"])
    assert pressed["elastic_over_theory"]["value"] == pytest.approx(1.0, rel=1e-6)
    assert pressed["theory_same_modes"] == pytest.approx(
        pressed["theory"], rel=0.1
    )  # two longest waves a side
    assert (
        0.5 < rough["elastic_over_theory"]["value"] < 1.0
    )  # partial contact has edges: shorter waves
