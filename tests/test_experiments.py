"""Each script of experiments/ runs in its toy size."""

import importlib.util
import re
import subprocess
import sys
from math import pi, sqrt
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import roughsim as rs
from roughsim.prediction import yield_wavenumber

ROOT = Path(__file__).parents[1]
SCRIPTS = sorted(
    path for path in (ROOT / "experiments").glob("*.py") if path.stem != "script"
)  # what they share
TABLES_ALONE = "few_spots_seen", "lay_camera", "lay_waves", "reactions_points"


@pytest.mark.slow
@pytest.mark.parametrize(
    "script",
    SCRIPTS,
    ids=lambda path: path.stem,
)
def test_the_toy_runs(script, tmp_path):
    if script.stem == "scans":
        pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    words = [sys.executable, script, "--toy", "-o", tmp_path]
    done = subprocess.run(
        words,
        capture_output=True,
        text=True,
        check=False,
        env={"PYTHONPATH": str(ROOT), "PATH": ""},
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout
    if script.stem not in TABLES_ALONE:
        assert list(tmp_path.glob("*.png"))


@pytest.mark.slow
def test_means_of_two_rough_steels_are_over_the_last_half_of_their_slide(tmp_path):
    # half of the heat warms each body as 2q√(Dt/π)/κ, and the mean of √s from 8 to 16 mm is √16 mm · 2/3 (2 − 2^(−1/2))
    script = ROOT / "experiments" / "two_bodies.py"
    words, env = [sys.executable, script, "-o", tmp_path], {"PYTHONPATH": str(ROOT), "PATH": ""}
    text = subprocess.run(
        words, capture_output=True, text=True, check=True, env=env, timeout=300
    ).stdout
    table = text[text.index("1.2GPa-f0.5-q1e+05-256-16mm") :]
    for speed in (1.0, 35.0):
        printed = re.search(rf"\n +{speed:g} m/s .*background ([0-9.]+) K", table)
        at_end = 2 * 0.5 * 0.11 * 90e6 * speed * sqrt(30 / (7900 * 500) * 16e-3 / speed / pi) / 30
        assert float(printed[1]) == pytest.approx(at_end * 2 / 3 * (2 - sqrt(0.5)), rel=0.01)


@pytest.fixture
def script(monkeypatch):
    """Import a script by its path, as another name than that of a package."""

    def load(path):
        monkeypatch.syspath_prepend(str((ROOT / path).parent))
        specification = importlib.util.spec_from_file_location(
            f"script_{Path(path).stem}", ROOT / path
        )
        module = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(module)
        return module

    return load


@pytest.mark.slow
def test_two_sliding_faces_with_skins_are_as_hot_as_their_theory(script):
    rows = list(script("experiments/skin.py").slide_rows(64))
    bare = rows[0][1]
    for _, hot, error, theory in rows:
        assert hot == pytest.approx(theory, rel=0.15)
        assert (error < 0.02 * hot).all()
        assert hot is bare or (hot > 1.2 * bare).all()


def test_an_interval_is_counted_if_it_reaches_the_reference_within_both_errors(script):
    coverage = script("experiments/coverage.py")
    truth = np.array([10.0]), np.array([0.01])
    rows = [
        {"flash_temperature": [[10.0 * (1 + off)], [0.2], [0.1]], "seconds": 1.0}
        for off in (0.0, 0.027, -0.029)
    ]
    off, stated, standard, held = coverage.judged(rows, "flash_temperature", truth)
    assert held.ravel().tolist() == [True, True, False]  # √(.02² + (1.96 · .01)²) = .028
    np.testing.assert_allclose(off.ravel(), [0.0, 0.027, -0.029], atol=1e-12)
    np.testing.assert_allclose([stated, standard], [[[0.02]] * 3, [[0.01]] * 3])
    table = coverage.summary({"steel": (None, 0.01, rows, {"flash_temperature": truth})})
    assert table[1] == ["steel, 1 %", "3", "2 (-0.03)", "–", "–", "–"]
    # at the second speed none holds
    worse = [{"flash_temperature": [[10.0, 11.0], [0.2, 0.2], [0.1, 0.1]]} for _ in rows]
    both = {"steel": (None, 0.01, rows, {"flash_temperature": truth})}
    both["worse"] = (
        None,
        0.01,
        worse,
        {"flash_temperature": (np.array([10.0, 10.0]), np.array([0.01, 0.01]))},
    )
    assert coverage.summary(both)[2] == ["worse, 1 %", "3", "0 (+5.00)", "–", "–", "–"]
    lower = [{"flash_temperature": [[10.1, 9.0], [0.2, 0.2], [0.1, 0.1]]} for _ in rows]
    below = {"lower": (None, 0.01, lower, both["worse"][3])}
    assert coverage.summary(below)[1][2] == "0 (-5.00)"
    assert coverage.counted(both) == {"scenes": 2, "intervals": 9, "hold": 5, "least_percent": 0.0}


def test_scenes_that_cost_much_get_fewer_seeds_but_eight(script, monkeypatch, tmp_path):
    coverage = script("experiments/coverage.py")
    monkeypatch.setattr(coverage, "one_run", lambda *_: {"seconds": 100.0, "counts": []})
    case = coverage.make_deep.cases()["demo"]
    numbers = {250.0: 8, 1000.0: 11, np.inf: 40}
    for seconds, number in numbers.items():
        rows = coverage.Rows(tmp_path / f"{seconds}.json")
        assert len(coverage.runs("demo", case, 0.01, 40, rows, seconds)) == number


def test_references_share_the_heat_of_like_bodies_evenly_at_rest_and_of_unlike_ones_by_their_conductivity(
    script,
):
    coverage = script("experiments/coverage.py")
    cases, deep = coverage.make_deep.cases(), coverage.Rows(coverage.make_deep.FILE, resume=True)
    found = {name: coverage.references(case, deep[name]) for name, case in cases.items()}
    assert "heat_partition" not in found["low H"]  # the flat is insulating
    assert found["steel-1.2GPa"]["heat_partition"][0][0] == pytest.approx(0.5, abs=1e-5)
    # 110 W/(m K) below 30: at rest the moving body would take 30/140; it moves slowly, and takes little more
    assert 30 / 140 < found["unlike faces"]["heat_partition"][0][0] < 1.2 * 30 / 140
    # force balance where all yields: g_σ(0) = σ₀σ_P − σ₀², and the area is σ₀/σ_P
    assert found["steel-1.2GPa"]["pressure_variance"][0][0] == pytest.approx(
        90e6 * (1.2e9 - 90e6), rel=3e-3
    )
    assert found["steel-1.2GPa"]["contact_fraction"][0][0] == pytest.approx(90e6 / 1.2e9, rel=3e-3)


@pytest.mark.slow
def test_drawn_scenes_have_ladders_that_double_in_cells_with_many_hot_spots(script):
    coverage = script("experiments/coverage.py")
    cases, most = coverage.drawn_cases(36), coverage.make_deep.DRAWN_SIDE
    assert len(cases) == 10
    for case in cases.values():
        length = 2 * np.pi / case.scene.spectrum.breaks[0] * case.waves
        cuts = np.array(case.cut_offs)
        assert cuts[0] == pytest.approx(case.first)
        assert case.members == (400, 160, 12)
        np.testing.assert_allclose(cuts[1:], 2 * cuts[:-1])
        assert case.cut_offs[-1] <= case.scene.spectrum.breaks[-1] * (1 + 1e-12)
        for _, cell, levels in coverage.make_deep.steps(case, length / case.parts):
            assert max(level.shape[0] for level in levels) <= most
            assert cell >= 0.25 * length / case.waves
        if case.scene.elastic:
            assert case.waves == 16
            assert case.first == pytest.approx(8 * case.scene.spectrum.breaks[0], rel=0.42)
        else:
            q_yield, load = yield_wavenumber(case.scene), case.scene.sliding.nominal_pressure
            assert cuts[0] == pytest.approx(2 * q_yield, rel=0.5)
            waves = length * q_yield / (2 * np.pi)
            assert waves >= 63.9
            assert waves**2 * load / case.scene.penetration_hardness >= 63.9


def test_a_reference_is_continued_to_the_end_of_the_spectrum_and_to_a_vanishing_pixel(script):
    deep = script("experiments/coverage.py").make_deep
    scene = rs.load_scene("demo")
    end, entries = scene.spectrum.breaks[-1], 2 * len(scene.speeds) + 2
    # 0.9: a step of −10 % from top/2 to top; by c/q_c as much again follows up to q_c = ∞
    names = {"lowest": 10.0, "q_c = 2": 0.9, "8 pixels": 0.96, "16 pixels": 0.98}
    factors = {
        name: {"factor": [factor] * entries, "variance": [0.0] * entries}
        for name, factor in names.items()
    }
    for part, step in {1.0: 0.0, 0.5: -0.05, 0.25: -0.075}.items():
        case = deep.Case(scene, 4, 1, part * end / 2, part * end, (1, 1, 1))
        found = deep.assembled(case, factors)
        for name, order in {"flash_temperature": 1.4, "contact_fraction_corrected": 0.9}.items():
            pixel = -0.02 / (2**order - 1)  # −.02 (2^−p + 2^−2p + …)
            np.testing.assert_allclose(
                found[name]["value"], 9.0 * 0.96 * 0.98 * (1 + step) * (1 + pixel)
            )
            np.testing.assert_allclose(found[name]["error"], np.hypot(step, pixel) / 2)


@pytest.mark.parametrize(("times", "area", "variance"), [(1.1, 1.1, 1.0), (0.9, 1.0, 0.9)])
def test_a_reference_lies_within_the_bounds_of_the_balance_of_forces(script, times, area, variance):
    deep = script("experiments/coverage.py").make_deep
    scene = rs.load_scene("demo")
    load, hardness, speeds = 90e6, 0.5e9, [1.0] * len(scene.speeds)
    numbers = [*speeds, times * load / hardness, times * load * (hardness - load), *speeds]
    still = {"factor": [1.0] * len(numbers), "variance": [0.0] * len(numbers)}
    factors = {"lowest": still | {"factor": numbers}, "q_c = 2": still, "8 pixels": still}
    end = scene.spectrum.breaks[-1]
    found = deep.assembled(deep.Case(scene, 4, 1, end / 2, end, (1, 1, 1)), factors)
    assert found["contact_fraction_corrected"]["value"] == pytest.approx([area * load / hardness])
    assert found["pressure_variance"]["value"] == pytest.approx(
        [variance * load * (hardness - load)]
    )
    assert found["flash_temperature"]["value"] == speeds


def test_an_elastic_reference_goes_on_with_the_ratio_of_its_last_two_steps(script):
    deep = script("experiments/coverage.py").make_deep
    scene = deep.elastic_scene()
    end, count = scene.spectrum.breaks[-1], 2 * len(scene.speeds) + 2
    steps = {"lowest": 10.0, "q_c = 1": 1.2, "q_c = 2": 1.1}
    # two doublings are left: halves and quarters of the last step; as it is where steps stay equal, grow or alternate
    for before, times in {1.21: 0.75, 1.1: 2.0, 1.05: 2.0, 1 / 1.1: 2.0, 1.0: 2.0}.items():
        rest = 1.1**times - 1.0
        factors = {
            name: {
                "factor": [before if name == "q_c = 1" else factor] * count,
                "variance": [0.0] * count,
            }
            for name, factor in steps.items()
        }
        found = deep.assembled(deep.Case(scene, 4, 1, end / 16, end / 4, (1, 1, 1)), factors)
        for row in found.values():
            np.testing.assert_allclose(row["value"], 10.0 * before * 1.1 * (1.0 + rest))
            np.testing.assert_allclose(row["error"], rest / 2)


@pytest.mark.slow
def test_drawn_scenes_are_what_they_were_drawn_to_be(script):
    drawn = script("benchmarks/drawn.py")
    sections = drawn.drawn_scenes()
    scenes = {name: rs.load_scene(each) for name, each in sections.items()}
    yielding = [scene for scene in scenes.values() if not scene.elastic]
    loads = np.sort(
        [scene.sliding.nominal_pressure / scene.penetration_hardness for scene in yielding]
    )
    times = np.sort([yield_wavenumber(scene) / scene.surface.q_min for scene in yielding])
    assert (len(scenes), len(yielding)) == (10, 8)
    assert (
        sum(scene.counterface is not None and scene.counterface.like is None for scene in yielding)
        == 2
    )
    # one in each eighth of the range, evenly in its logarithm; three digits of what was drawn
    for found, low, high in ((loads, 0.003, 0.4), (times, 1.0, 30.0)):
        np.testing.assert_array_equal(
            np.floor(8 * np.log(found / low) / np.log(high / low)), range(8)
        )
    assert drawn.drawn_scenes(1) != sections
    no_room = drawn.drawn_scenes(40009)["unlike 2"][
        "counterface"
    ]  # drawn with a roll-off above its q_max
    assert "q_roll_off" not in no_room
    assert "roll_off_exponent" not in no_room


def test_earlier_versions_are_asked_for_what_their_plan_leaves_of_the_target(script):
    chain = script("benchmarks/chain.py")
    assert chain.asked_of_run(SimpleNamespace(), 0.01) == 0.01
    forecast = SimpleNamespace(bandwidth=0.004, pixel=np.nan, size=0.003)
    assert chain.asked_of_run(SimpleNamespace(forecast=forecast), 0.01) == pytest.approx(
        0.01 * sqrt(0.75)
    )
    assert chain.asked_of_run(SimpleNamespace(forecast=forecast), 0.004) == pytest.approx(
        0.004 * sqrt(0.1)
    )


def test_the_plain_script_continues_corrections_that_halve(script):
    # 134 K, and changes of −32, −16, −8 K …: 70 K in the end, −8 K of them beyond the last level
    plain = script("benchmarks/plain.py")
    levels = [[np.array([value])] * 3 for value in (134.0, -32.0, -16.0)]
    found, variances = plain.extrapolated([*levels, [np.array([-8.0])] * 2], [0.5] * 4)
    assert found.mean == pytest.approx([70.0], rel=1e-12)
    assert found.rest == pytest.approx([0.5 * 8 / 70], rel=1e-12)
    assert found.members == [3, 3, 3, 2]
    np.testing.assert_array_equal(variances, 0.0)
    # −16 K in place of −8 K: 54 K in place of 70
    slower, _ = plain.extrapolated([*levels, [np.array([-16.0])] * 2], [0.5] * 4)
    assert slower.rest == pytest.approx([(70.0 - 54.0) / 54.0], rel=1e-12)
    # a third of the last change follows where only the pixel is left
    whole, _ = plain.extrapolated([*levels, [np.array([-9.0])] * 2], [0.5, 0.5, 0.5, 0.25])
    assert whole.mean == pytest.approx([134.0 - 32.0 - 16.0 - 9.0 - 3.0], rel=1e-12)


def test_the_page_of_the_theory_shows_the_numbers_of_the_paper_as_computed(script):
    shown = (ROOT / "docs" / "reference" / "paper.txt").read_text()
    assert shown == script("experiments/paper.py").table(), (
        "run python experiments/paper.py; copy runs/paper/paper.txt"
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", ["two_bodies", "yielding"])
def test_the_linked_tables_are_those_of_their_scripts(name, tmp_path):
    words, env = (
        [sys.executable, ROOT / "experiments" / f"{name}.py", "-o", tmp_path],
        {"PYTHONPATH": str(ROOT), "PATH": ""},
    )
    printed = subprocess.run(
        words, capture_output=True, text=True, check=True, env=env, timeout=600
    ).stdout
    shown = (ROOT / "docs" / "reference" / f"{name}.txt").read_text()
    assert printed.startswith(shown), (
        f"copy what experiments/{name}.py prints to docs/reference/{name}.txt"
    )


def test_the_least_time_to_an_error_is_that_of_any_tolerance_which_meets_it(script):
    solvers = script("experiments/contact_solvers.py")
    same = {"solver": "tamaas", "problem": "load 0.1", "points": 512}
    rows = [
        same | {"error": error, "seconds": t}
        for error, t in ((1e-2, 1.0), (1e-4, 3.0), (5e-4, 4.0), (None, 0.1))
    ]
    rows.append(same | {"points": 256, "error": 1e-9, "seconds": 0.2})
    assert solvers.cheapest(rows, "tamaas", "load 0.1", 512, 1e-3) == 3.0
    assert solvers.cheapest(rows, "tamaas", "load 0.1", 512, 1e-5) is None
    assert solvers.cheapest(rows, "NuMPI", "load 0.1", 512, 1e-3) is None


def test_the_bias_of_a_way_counts_at_its_worst_speed_and_is_a_bound_where_scatter_hides_it(script):
    ways = script("experiments/chain_ways.py")
    row = {"bias": [0.01, -0.07], "scatter": [0.0, 0.04], "doubt": [0.0, 0.0], "members": 16}
    assert ways.worst_bias(row) == "7"
    # 1.96 √((.2/√16)² + .03²) = .114 is more than .07
    assert ways.worst_bias(row | {"scatter": [0.0, 0.2], "doubt": [0.0, 0.03]}) == "≤ 11"
    assert ways.worst_bias({"bias": [1.37], "doubt": [0.01]}) == "137"
    assert ways.worst_bias({"bias": [float("nan")], "doubt": [0.01]}) == "–"


def test_the_table_of_heat_has_the_least_time_to_a_hundredth_or_the_least_error(script):
    heat = script("experiments/heat_methods.py")
    rows = [
        {"source": "Hertz", "method": method, "peclet": 10.0, "error": error, "seconds": seconds}
        for method, error, seconds in (
            ("free", 0.02, 1e-3),
            ("free", 0.009, 3e-3),
            ("steady", 0.4, 1.0),
            ("steady", 5, 1),
        )
    ]
    assert heat.table_of(rows)[1:] == [["Hertz", "free", "3"], ["Hertz", "steady", "(40 %)"]]


def test_the_line_behind_the_rim_follows_the_circle(script):
    camera = script("experiments/camera.py")
    grid = rs.Grid((192, 128), camera.SIDES)
    x, y = camera.places(grid)
    line = camera.along_rim(3.0 * x[:, None] + 5.0 * y, grid, 2e-4)
    chosen = y[np.abs(y) < 0.9e-3]
    np.testing.assert_allclose(line, 3.0 * (np.sqrt(1e-6 - chosen**2) - 2e-4) + 5.0 * chosen)


def test_a_point_spread_lowers_a_gaussian_track(script):
    # as high as w/√(w² + s²), by convolution of two Gaussians of full widths w and s
    camera, pixel, width, spread = script("experiments/camera.py"), 1e-6, 5e-5, 7e-5
    y = pixel * np.arange(-2000, 2001)
    line = 7.0 + 300.0 * 2.0 ** -((2 * y / width) ** 2)
    assert camera.hottest(line, pixel) == pytest.approx(300.0, rel=1e-9)
    seen = 300.0 * width / np.hypot(width, spread)
    assert camera.hottest(line, pixel, spread) == pytest.approx(seen, rel=1e-3)


def test_radiance_reads_high_by_the_variance_in_the_blur(script):
    # 1/2 s² f″/f′ of f = exp(−c/T) at T: s²/2 (c/T² − 2/T)
    camera = script("experiments/camera.py")
    field = np.where(np.arange(64) % 2, 202.0, 198.0).reshape(8, 8)

    def blur(field):
        return np.full(field.shape, field.mean())

    c, T = 14387.77 / 0.9, 1173.0
    high = 2.0**2 / 2 * (c / T**2 - 2 / T)
    assert camera.radiance_reading(field, blur(field), blur) == pytest.approx(
        high / 200.0, rel=1e-3
    )


def test_heat_behind_the_rim_is_that_of_moving_point_sources(script):
    # Rosenthal: q̇ e^(−v(r + x)/2D)/(2πκr), each heated pixel in 9 × 9 parts
    camera = script("experiments/camera.py")
    grid = rs.Grid((96, 64), camera.SIDES)
    stress = np.zeros(grid.shape)
    stress[60:70, 30:34] = 1e9
    x, y = camera.places(grid)
    field, diffusivity = camera.rise(stress, grid, 0.5), 30.0 / (7900 * 500)
    parts = (np.arange(9) - 4) / 9 * grid.spacing[0]
    total = 0.0
    for i, j in zip(*stress.nonzero(), strict=True):
        along = x[40] - (x[i] + parts)[:, None]
        apart = np.hypot(along, y[31] - (y[j] + parts))
        fall = np.exp(-35.0 * (apart + along) / (2 * diffusivity))
        total += np.mean(fall / apart)
    heat = 0.5 * 0.11 * 35.0 * 1e9 * grid.spacing[0] ** 2
    assert field[40, 31] == pytest.approx(heat * total / (2 * pi * 30.0), rel=2e-3)
