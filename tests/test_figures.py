"""The figures of the pages: what their maps show, and the one style of those from files of evidence."""

import sys
from contextlib import contextmanager
from math import inf, nan
from pathlib import Path

import numpy as np
import pytest
from matplotlib.legend import Legend
from matplotlib.text import Text

ROOT = Path(__file__).parents[1]
NARROWEST, LEAST = 390, 8.0  # pixels: a telephone, and the height of letters there


@pytest.fixture
def drawn(monkeypatch):
    """Draw a figure as its function does; return the figure with what is in it."""
    monkeypatch.syspath_prepend(str(ROOT / "experiments"))
    import figures

    def draw(function, rows, path):
        found = []
        module = sys.modules[function.__module__]
        usual = module.new_figure

        @contextmanager
        def kept(*words):
            with usual(*words) as figure:
                found.append(figure)
                yield figure

        monkeypatch.setattr(module, "new_figure", kept)
        function(*rows, path)
        monkeypatch.setattr(module, "new_figure", usual)
        return found[0]

    return figures, draw


def test_a_map_of_solvers_has_colours_of_decades_a_cross_where_it_failed_and_white_without_a_solver(
    drawn, tmp_path
):
    figures, draw = drawn
    row = {"solver": "tamaas", "load": 0.1, "ratio": inf, "why": ""}
    rows = [
        row | {"error": 3.2e-7},
        row | {"ratio": 3.0, "error": 2e-4},
        row | {"load": 1.0, "error": nan, "why": "stopped"},
        row | {"load": 1.0, "ratio": 3.0, "why": "one bound only"},
        {"kernel": "free half-space", "peclet": 1.0},  # a row of another map
    ]
    axes = draw(figures.limits_of_solvers, [rows], tmp_path / "map.png").axes[0]
    (image,) = axes.images
    table = np.ma.filled(image.get_array(), nan)
    assert [int(image.norm(table[i, 0])) for i in (0, 1)] == [3, 0]
    assert int(image.norm(table[1, 1])) == 5
    assert np.isnan(table[0, 1])
    (crosses,) = axes.lines
    np.testing.assert_array_equal(crosses.get_xydata(), [[1.0, 1.0]])


def test_a_map_of_the_pixel_has_lines_of_per_cent_and_leaves_other_solvers_out(drawn, tmp_path):
    # the error is 1 + 9x % between bandwidths 2 and 8: the line of 3 % lies at x = 2/9
    figures, draw = drawn
    row = {"solver": "roughsim", "pixels": 2.0}
    rows = [
        row | {"bandwidth": bandwidth, "hurst": hurst, "pixel_error": error}
        for bandwidth, error in ((2.0, 0.01), (8.0, 0.10))
        for hurst in (0.3, 0.8)
    ]
    rows.append(row | {"solver": "tamaas", "pixels": 16.0})
    (axes,) = draw(figures.limits_of_pixel, [rows], tmp_path / "map.png").axes
    lines = axes.collections[-1]
    level = list(lines.levels).index(3.0)
    np.testing.assert_allclose(lines.get_paths()[level].vertices[:, 0], 2 / 9, rtol=1e-9)


@pytest.mark.slow
def test_letters_can_be_read_on_a_telephone_and_no_legend_hides_data(drawn, monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    import evidence

    _, draw = drawn
    for name, (files, function) in evidence.DRAWN.items():
        figure = draw(
            function, [evidence.evidence(file)["rows"] for file in files], tmp_path / name
        )
        scale = NARROWEST / figure.get_figwidth() / 72  # pixels of a point
        for text in figure.findobj(Text):
            if text.get_text() and text.get_visible():
                assert text.get_fontsize() * scale >= LEAST * 0.95, f"{name}: {text.get_text()!r}"
        for legend in figure.findobj(Legend):
            assert not any(label.get_text().startswith("_") for label in legend.get_texts()), name
            place = legend.get_window_extent()
            assert not any(
                place.overlaps(axes.get_window_extent())
                for axes in figure.axes
                if axes.get_visible()
            ), name
