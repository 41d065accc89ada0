"""Pictures of a run: each says what it is of, lies where it is told to, and is refused where it cannot be drawn."""

from contextlib import chdir

import numpy as np
import pytest
from chart_cases import SPEED
from matplotlib.text import Text
from refused_cases import assert_refused
from some_rows import some

import roughsim as rs
from roughsim.charts.plot import QUANTITIES, plot_run
from roughsim.charts.style import scaled
from roughsim.cli import main
from roughsim.estimate.asked import ABOUT

ASKED = ("sliding", "reaction", *ABOUT, "snapshots", "seen")  # of other scenes
DRAWN = [quantity for quantity in QUANTITIES if quantity not in ASKED]


@pytest.mark.parametrize("quantity", some(DRAWN, 2))
def test_every_picture_says_what_it_is_of(capped_run, drawn, quantity):
    plot_run(capped_run, quantity)
    text = " ".join(text.get_text() for text in drawn[0].findobj(Text))
    assert "small capped" in text
    assert "capped contact" in text
    assert ("35 m/s" in text) == (quantity in SPEED)  # the highest speed unless told
    assert ("realization 0" in text) == (quantity not in ("spectrum", "correlation"))
    unit = {
        "heights": "µm",
        "pressure": "GPa",
        "heat_flux": "GW/m²",
        "spectrum": "m⁴",
        "correlation": "GPa²",
    }
    assert unit.get(quantity, "(K)") in text


@pytest.mark.parametrize(
    ("ending", "start"),
    [
        (".png", b"\x89PNG"),
        pytest.param(".pdf", b"%PDF", marks=pytest.mark.slow),  # below, too
        pytest.param(".SVG", b"<?xml", marks=pytest.mark.slow),
    ],
)
def test_the_ending_says_the_format(capped_run, tmp_path, ending, start):
    assert (
        plot_run(capped_run, "pressure", tmp_path / "new" / f"one{ending}")
        .read_bytes()
        .startswith(start)
    )


@pytest.mark.slow
def test_pictures_lie_beside_the_run(capped_run):
    first = plot_run(capped_run, "heights")
    assert first == capped_run.folder.resolve().parent / "capped-heights.png"
    second = plot_run(capped_run, "temperature", realization=0, speed=0.1, column="smoothed")
    assert second == first.with_name("capped-temperature-smoothed-r0-0.1mps.png")
    for path in (first, second):
        assert path.stat().st_size > 10_000
        path.unlink()


@pytest.mark.slow
@pytest.mark.parametrize("quantity", DRAWN)
def test_full_contact_in_an_oblong_cell_is_drawn_too(full_run, tmp_path, quantity):
    text = plot_run(full_run, quantity, tmp_path / "one.svg").read_text()
    assert "costs $5 &amp; more $" in text  # a title is no formula
    assert "elastic contact" in text


WRONG = {  # words → quantity and options
    "quantity = 'gap' cannot be drawn; choose one of heights, pressure": ("gap", {}),
    "'contact_area' cannot be drawn; choose one of heights, .*, flash_temperature": (
        "contact_area",
        {},
    ),
    "must end in .png, .pdf, .svg": ("heights", {"path": "a.gif"}),
    "column = 'elastic' is not in this run": ("heights", {"column": "elastic"}),
    "fields of realization 4 at level 2; .*--keep-fields 5.*index=4": (
        "pressure",
        {"realization": 4},
    ),
    'has no column "sliding"': ("sliding", {}),
    r"add \[observables\] with temperature_distribution = true and run it in an": ("reaction", {}),
    r"has no reaction_rate: .*; add \[reaction\] with activation_energy": ("reaction_rate", {}),
    r"has no heat_share_above: .*; add \[observables\] with heat_above": ("heat_share_above", {}),
    "has no temperature_quantile_99: .*; add": ("temperature_quantile_99", {}),
    r"add \[reaction\] with activation_energy, prefactor and contact_length": ("conversion", {}),
    'has no snapshots of realization 0; run a scene with history = "sliding"': ("snapshots", {}),
    "sliding has a column of its own": ("sliding", {"column": "capped"}),
    "mean over all": ("correlation", {"realization": 0}),
    "speed: flash_temperature is of all members; leave it out": (
        "flash_temperature",
        {"speed": 1.0},
    ),
    "over = 'speed' is for studies": ("flash_temperature", {"over": "speed"}),
    "speed = 1 m/s: heights does not depend on it": ("heights", {"speed": 1.0}),
    "speed = 0 m/s makes no heat": ("temperature", {"speed": 0.0}),
    "speed = inf m/s must be finite": ("profile", {"speed": np.inf}),
    "are for maps, and profile is not a map": ("profile", {"zoom": ((0.0, 1e-3), (0.0, 1e-3))}),
    "maps, and profile is not a map": ("profile", {"side_by_side": True}),
    "size = 0.5 × 3 inches: each side must be 1.5 to 40 inches": ("heights", {"size": (0.5, 3.0)}),
    "size = 3 × nan inches": ("heights", {"size": (3.0, float("nan"))}),
    "dpi = 5 must be 30 to 1200": ("heights", {"dpi": 5}),
}


@pytest.mark.parametrize("words", WRONG)
def test_plot_refuses_by_name_and_value(capped_run, tmp_path, words):
    quantity, options = WRONG[words]
    with chdir(tmp_path):
        assert_refused(lambda: rs.plot(capped_run, quantity, **options), words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_command_line_draws_and_complains_in_one_line(capped_run, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(
            [
                "plot",
                str(capped_run.folder),
                "profile",
                "-o",
                str(tmp_path / "a.png"),
                "--speed",
                "-0.1",
                "-r",
                "0",
            ]
        )
    assert ended.value.code == 0
    assert "picture: " in capsys.readouterr().err
    assert (tmp_path / "a.png").exists()
    with pytest.raises(SystemExit) as ended:
        main(["plot", str(capped_run.folder), "gap"])
    assert ended.value.code == 1
    drawing, complaint = capsys.readouterr().err.splitlines()
    assert drawing == f"roughsim: drawing gap of {capped_run.folder}"
    assert complaint.startswith("roughsim: quantity = 'gap'")


@pytest.mark.slow
def test_the_command_line_takes_zoom_and_side_by_side(capped_run, tmp_path, capsys):
    words = [
        "plot",
        str(capped_run.folder),
        "temperature",
        "--zoom",
        "0:1e-3,5e-4:2e-3",
        "--side-by-side",
    ]
    with pytest.raises(SystemExit) as ended:
        main([*words, "-o", str(tmp_path / "a.pdf")])
    assert ended.value.code == 0
    assert (tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")
    with pytest.raises(SystemExit):
        main(["plot", str(capped_run.folder), "heights", "--zoom", "1,2"])
    assert "--zoom 1,2: write X0:X1,Y0:Y1 in m" in capsys.readouterr().err


def test_units_get_the_prefix_that_keeps_numbers_readable():
    cases = {
        (3.2e-6, "m"): ("µm", 3.2),
        (1e-3, "m"): ("mm", 1.0),
        (999e-9, "m"): ("nm", 999.0),
        (2.0, "m"): ("m", 2.0),
    }
    cases |= {
        (5e8, "Pa"): ("MPa", 500.0),
        (1e9, "Pa"): ("GPa", 1.0),
        (2e9, "W/m^2"): ("GW/m^2", 2.0),
    }
    cases |= {(1500.0, "K"): ("K", 1500.0), (0.0, "m"): ("m", 0.0)}
    for (value, unit), (name, number) in cases.items():
        factor, shown = scaled(value, unit)
        assert shown == name
        assert value * factor == pytest.approx(number, rel=1e-12)
