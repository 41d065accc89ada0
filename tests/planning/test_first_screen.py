"""What `plan` and `theory` print by default fits a first screen: 25 lines of 80 columns, the answer on top."""

import re
import warnings

import pytest
from some_rows import some
from typer.testing import CliRunner

import roughsim as rs
from roughsim.cli import app
from roughsim.scene import bundled_scenes

CHANGES = {
    "as bundled": (),
    "seven warnings": (
        "body.youngs_modulus=210",
        "counterface=",
        "sliding.heat_partition=1",
        "sliding.direction=30deg",
        "sliding.friction_coefficient=11",
        "sliding.background_temperature=25",
        "body.density=7.9",
    ),
    "many speeds": (f"sliding.speed={[round(0.1 * k, 3) for k in range(1, 41)]}",),
    "a long title": (f"title={'word ' * 39}end",),
    "tables": (
        "body.conductivity={temperature=[293, 3000], value=[30, 20]}",
        "sliding.background_temperature=293",
    ),
    "two bodies that slide": (
        'sliding.history="sliding"',
        "sliding.slid_distance=4mm",
        'sliding.heat_partition="mean"',
    ),
}


def printed(verb, scene, *words):
    changes = [word for change in words for word in ("--set", change)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        done = CliRunner().invoke(app, [verb, scene, *changes])
    assert done.exit_code == 0, done.output
    return done


@pytest.mark.parametrize("verb", ["plan", "theory"])
@pytest.mark.parametrize(
    ("scene", "changes"),
    some(
        [
            *(
                (name, "as bundled")
                for name in bundled_scenes()
                if name not in ("steel-0.5GPa", "steel-2.0GPa")
            ),
            *(("steel-1.2GPa", changes) for changes in CHANGES if changes != "as bundled"),
        ],
        3,
    ),
)
def test_first_screen_is_short(verb, scene, changes):
    lines = printed(verb, scene, *CHANGES[changes]).output.splitlines()
    assert len(lines) <= 25
    assert max(map(len, lines)) <= 80
    assert sum(line.startswith("roughsim: warning") for line in lines) <= 3
    assert any("--all prints " in line for line in lines)


def test_first_screen_begins_with_the_answer():
    theory = rs.theory("demo")
    band = 0.07  # of the calibrated law
    first = printed("theory", "demo").stdout.splitlines()[3].split()
    value, error = float(first[1]), float(first[3])
    assert value == pytest.approx(theory.calibrated[-1], rel=1e-2)
    assert error == pytest.approx(band * theory.calibrated[-1], rel=2e-2)
    assert re.match(
        r"CPU time +\S+ s to \S+ s, to a", printed("plan", "demo").stdout.splitlines()[1]
    )


def test_theory_without_the_law_is_of_unknown_error():
    assert "1228 ± unknown" in printed("theory", "granite").stdout


def test_all_has_the_warnings_that_the_first_screen_leaves_out():
    changes = [word for one in CHANGES["seven warnings"] for word in ("--set", one)]
    words = ["theory", "steel-1.2GPa", *changes]
    done, every = CliRunner().invoke(app, words), CliRunner().invoke(app, [*words, "--all"])
    left_out = int(re.search(r"and (\d+) more warnings", done.output)[1])
    assert every.output.count("roughsim: warning: ") == 3 + left_out >= 6
    # the most serious are there: numbers of no solid before assumptions
    assert "youngs_modulus = 210 Pa" in done.output
    assert "direction" not in done.stderr
    rows = int(re.search(r"--all prints (\d+) rows", done.output)[1])
    assert every.stdout.count("\n") >= rows
