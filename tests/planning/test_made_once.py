"""A command makes its scene, and what follows from it, once."""

import functools
from collections import Counter

import numpy as np
import pytest
from small_scene import CAPPED

import roughsim as rs
from roughsim import cli
from roughsim.planning import limits
from roughsim.prediction import scans
from roughsim.scene import Scene


@pytest.fixture
def made(monkeypatch):
    """Counts of scenes, and of what follows from them, since the test began."""
    counts = Counter()

    def count(owner, name):
        function = getattr(owner, name)

        @functools.wraps(function)
        def counting(*arguments, **keys):
            counts[name] += 1
            return function(*arguments, **keys)

        monkeypatch.setattr(owner, name, counting)

    for owner, name in (
        (Scene, "__init__"),
        (limits, "facts_of"),
        (limits, "statements"),
        (limits, "cell_of"),
        (scans, "_error_of_face"),
    ):
        count(owner, name)
    return counts


def command(*words):
    with pytest.raises(SystemExit) as ended:
        cli.main([str(word) for word in words])
    assert ended.value.code == 0


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(CAPPED)
    return path


def test_scene_is_made_once(made, file, tmp_path):
    verbs = {
        "plan": lambda: rs.plan(file),
        "plan of a target": lambda: rs.plan(file, "5 %"),
        "theory": lambda: rs.theory(file).summary(),
        "run": lambda: rs.run(file, tmp_path / "run", max_realizations=2, progress=False),
        "run that goes on": lambda: rs.run(file, tmp_path / "run", realizations=2, progress=False),
        "compare": lambda: rs.compare(tmp_path / "run").summary(),
        "roughsim plan": lambda: command("plan", file, "--target-error", "5%"),
        "roughsim theory": lambda: command("theory", file, "--trust"),
        "roughsim run": lambda: command("run", file, "-o", tmp_path / "run", "--max", 2),
    }
    found = {}
    for name, verb in verbs.items():
        made.clear()
        verb()
        found[name] = made["__init__"]
    assert found == dict.fromkeys(verbs, 1)


@pytest.mark.slow
def test_facts_and_statements_are_computed_once(made, file, tmp_path):
    found = {}
    for words in (
        ("plan", file),
        ("plan", file, "--all"),
        ("theory", file),
        ("theory", file, "--all"),
        ("run", file, "-o", tmp_path / "run", "--max", 2),
        ("compare", tmp_path / "run"),
        ("compare", tmp_path / "run", "--all"),
    ):
        made.clear()
        command(*words)
        found[words[::2]] = made["facts_of"], made["statements"]
        assert made["cell_of"] == (words[0] == "theory")
    # a run warns before its work, and again beside its results, by the share of the heat that it measured; what is
    # assumed stands beside results by --all
    run, short = ("run", "-o", "--max"), ("compare",)
    assert found == {
        words: (2 if words == run else 1, int(words not in (run, short))) for words in found
    }


@pytest.mark.slow
def test_error_of_a_scan_is_computed_once(made, tmp_path):
    """T_flash alone for a plan, all observables for a run: each once."""
    grid = rs.Grid((96, 96), (1e-3, 1e-3))
    law = rs.SelfAffineSpectrum.from_rms_height(9e-7, hurst=0.8, q_min=2e4, q_max=2e5)
    heights = rs.synthesize(law, grid, np.random.default_rng(3), amplitudes="gaussian")
    np.save(tmp_path / "map.npy", heights)
    surface = '[surface]\ntopography = "map.npy"\ntopography_size = "1 mm"\ntopography_unit = "m"\n'
    of_others = CAPPED[CAPPED.index("[body]") :].replace('like = "body"', "conductivity = 30\n")
    others = of_others.replace("[sliding]", "density = 7900\nheat_capacity = 500\n[sliding]")
    path = tmp_path / "scan.toml"
    path.write_text(surface + others.replace("[2e-3, 2e-3]", "[4e-3, 4e-3]"))
    found = []
    for words in (
        ("plan", path),
        ("theory", path),
        ("run", path, "-o", tmp_path / "run"),
        ("compare", tmp_path / "run"),
        ("compare", tmp_path / "run", "--all"),
    ):
        command(*words)
        found.append(made["_error_of_face"])
    assert found == [1, 1, 2, 2, 2]
