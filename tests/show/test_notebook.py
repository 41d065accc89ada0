"""What a notebook shows of a run, a comparison and the like: small, without scripts, all text escaped."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

import roughsim as rs
from roughsim.show.table import table_text

HOSTILE = "<script>alert(1)</script> & <b>bold</b>"


class Strict(HTMLParser):
    """Refuses scripts, styles of other kinds than alignment, addresses, and elements that are not closed."""

    def __init__(self, html):
        super().__init__()
        self.open, self.words, self.tables = [], [], 0
        self.feed(html)
        assert self.open == []
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag, attributes):
        assert tag in {
            "div",
            "p",
            "strong",
            "table",
            "thead",
            "tbody",
            "tr",
            "th",
            "td",
            "details",
            "summary",
            "sup",
        }
        self.open.append(tag)
        self.tables += tag == "table"
        for name, value in attributes:
            assert name in {"class", "colspan", "scope", "style"}
            if name == "style":
                assert set(re.findall(r"([\w-]+):", value)) <= {"text-align", "white-space"}

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


@pytest.fixture(scope="module")
def hostile(quick_module, tmp_path_factory):
    """A run whose title is HTML."""
    return rs.run(
        replace(quick_module, title=HOSTILE),
        tmp_path_factory.mktemp("html") / "run",
        max_realizations=3,
    )


@pytest.fixture(scope="module")
def quick_module(capped_scene):
    levels = ({"column": "capped", "shape": [32, 32], "q_max": 4e4},)
    return replace(capped_scene, numerics=replace(capped_scene.numerics, levels=levels))


def shown(thing):
    html = thing._repr_html_()
    assert len(html) < 30_000
    return Strict(html)


def test_all_are_tables_that_only_say_what_is_in_them(hostile):
    things = [
        hostile,
        rs.compare(hostile),
        hostile.estimate("flash_temperature"),
        hostile.scene,
        hostile.numerics,
    ]
    for thing in things:
        assert shown(thing).tables == 1
    for thing in (hostile, rs.compare(hostile), hostile.scene):
        assert HOSTILE in shown(thing).text
        assert "<script" not in thing._repr_html_()


def test_a_run_shows_its_flash_temperature_with_the_total_error(hostile):
    estimate = hostile.estimate("flash_temperature")
    for k in range(3):
        assert str(estimate.number(k)) in shown(hostile).text


def test_an_estimate_shows_its_speeds_and_the_parts_of_its_error(hostile):
    text = shown(hostile.estimate("flash_temperature")).text
    for word in (
        "flash_temperature, K: 3 realizations",
        "speed, m/s",
        "35",
        "statistical",
        "bandwidth",
        "solver",
    ):
        assert word in text
    assert "speed" not in shown(hostile.estimate("contact_fraction")).text.partition("notes")[0]


def test_a_run_without_realizations_says_so(quick_module, tmp_path):
    from roughsim.ensemble.run import begin

    begin(quick_module, tmp_path / "begun")
    assert "0 realizations" in shown(rs.open_run(tmp_path / "begun")).text


def test_a_scene_shows_its_keys_with_their_units(hostile):
    text = shown(hostile.scene).text
    assert (
        "sliding.nominal_pressure 90000000 Pa" in text
        or "sliding.nominal_pressure 9e+07 Pa" in text
    )
    assert "sliding.speed [0.0, 0.1, 35.0] m/s" in text
    assert "surface.hurst 0.8" in text


def test_numerics_show_their_levels(capped_run):
    text = shown(capped_run.numerics).text
    for words in ("0 smoothed 64 × 64 50000", "2 capped 128 × 128", "Cell 2 × 2 mm"):
        assert words in text


@pytest.mark.slow
def test_printing_a_comparison_is_the_table_of_the_command_line(capped_run, capsys):
    from roughsim.cli import main

    comparison = rs.compare(capped_run)
    shown = {"": str(comparison), "--all": table_text(comparison.table())}
    for option, text in shown.items():
        with pytest.raises(SystemExit):
            main(["compare", str(capped_run.folder), *option.split()])
        printed = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
        assert printed[: len(text.splitlines())] == text.splitlines()
    for row in comparison.rows:
        assert any(line.startswith(row.observable) for line in shown["--all"].splitlines())
    for key in (
        "theory",
        "calibrated",
        "smoothed",
        "capped",
        "smoothed_over_theory",
        "capped_over_smoothed",
    ):
        assert key in comparison.to_dict()["rows"][0]
        assert key in shown["--all"]


def test_a_data_frame_has_the_numbers_of_the_comparison(capped_run):
    pytest.importorskip("pandas")
    comparison = rs.compare(capped_run)
    frame = comparison.to_dataframe()
    assert len(frame) == len(comparison.rows)
    fast = frame[frame.speed == 35.0].loc["flash_temperature"]
    estimate = capped_run.estimate("flash_temperature")
    assert (fast.capped, fast.capped_total_error) == (estimate.mean[2], estimate.total_error[2])
    assert fast.unit == "K"
    area = frame.loc["contact_fraction"]
    assert np.isnan(area.speed)
    assert area.capped_over_smoothed == pytest.approx(area.capped / area.smoothed)
    keys = comparison.to_dict()["rows"][0]
    assert {key for key in keys if key != "observable"} <= set(frame.columns)


def test_a_data_frame_says_what_to_install(capped_run, without):
    without("pandas")
    with pytest.raises(ImportError, match="pip install pandas"):
        rs.compare(capped_run).to_dataframe()


def test_the_package_lists_public_names_alone():
    assert hasattr(rs, "show")  # a submodule that was imported is no public name
    assert dir(rs) == sorted(rs.__all__)
    assert all(not name.startswith("_") or name == "__version__" for name in dir(rs))
    assert "show" not in dir(rs)
