"""Numerics: which level corrects which, on which grids and streams, and what is refused."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

import roughsim as rs
from roughsim.grid import Grid
from roughsim.scene.numerics import Level, Numerics

SIDE = 2e-3
# two columns in disorder: capped 5e4 with a partner, 1e5 in half the cell with a partner there, 2e5 in a quarter
CAPPED = (
    Level("capped", (32, 32), 2e5, "quarter"),
    Level("capped", (64, 64), 5e4),
    Level("smoothed", (128, 128), 3e4),
    Level("capped", (128, 128), 5e4),
    Level("capped", (64, 64), 1e5, "half"),
    Level("smoothed", (64, 64), 3e4),
    Level("capped", (128, 128), 1e5, "half"),
    Level("sliding", (64, 64), 5e4, first=3),
)
TOP, LOWEST, FINE_SMOOTHED, PARTNER, MIDDLE, SMOOTHED, MIDDLE_PARTNER, SLIDE = range(8)


@pytest.fixture(scope="module")
def numerics():
    return Numerics((replace(CAPPED[0], shape=(64, 64)), *CAPPED[1:]), (SIDE, SIDE))


def test_levels_of_a_column_are_ordered_by_cut_off_then_by_pixel(numerics):
    assert numerics.columns == ("smoothed", "capped")
    assert numerics.of_column("capped") == (LOWEST, PARTNER, MIDDLE, MIDDLE_PARTNER, TOP)
    assert numerics.of_column("smoothed") == (SMOOTHED, FINE_SMOOTHED)
    assert numerics.coarse_levels("capped") == (LOWEST, MIDDLE, TOP)
    assert numerics.coarse_levels("smoothed") == (SMOOTHED,)
    assert (numerics.slide, list(numerics.single)) == (SLIDE, list(range(SLIDE)))


def test_a_level_corrects_the_next_lower_cut_off_and_a_partner_the_pixel(numerics):
    below = {LOWEST: None, PARTNER: LOWEST, MIDDLE: LOWEST, MIDDLE_PARTNER: MIDDLE, TOP: MIDDLE}
    below |= {SMOOTHED: None, FINE_SMOOTHED: SMOOTHED, SLIDE: None}
    assert {level: numerics.below(level) for level in range(8)} == below
    refined = {LOWEST: PARTNER, MIDDLE: MIDDLE_PARTNER, SMOOTHED: FINE_SMOOTHED}
    assert {level: numerics.refined(level) for level in range(8)} == dict.fromkeys(
        range(8)
    ) | refined
    assert [level for level in range(8) if numerics.is_refined(level)] == sorted(refined.values())


def test_the_level_below_keeps_its_pixel_in_the_cell_of_the_level(numerics):
    assert numerics.grid(MIDDLE) == Grid((64, 64), (SIDE / 2, SIDE / 2))
    assert numerics.grid_below(MIDDLE) == Grid((32, 32), (SIDE / 2, SIDE / 2))
    assert numerics.grid_below(MIDDLE_PARTNER) == numerics.grid(MIDDLE)
    assert numerics.grid_below(TOP) == Grid((32, 32), (SIDE / 4, SIDE / 4))
    assert numerics.grid_below(PARTNER) == numerics.grid(LOWEST)
    for level in (TOP, PARTNER, MIDDLE, FINE_SMOOTHED, MIDDLE_PARTNER):
        below = numerics.grid(numerics.below(level))
        assert numerics.grid_below(level).spacing == pytest.approx(below.spacing, rel=1e-15)
    with pytest.raises(ValueError, match=f"level {LOWEST} has none below it"):
        numerics.grid_below(LOWEST)


def test_each_level_has_surfaces_of_its_own_but_the_lowest_ones_are_paired(numerics):
    streams = [numerics.stream(level) for level in range(8)]
    assert streams[LOWEST] == streams[SMOOTHED] == LOWEST
    assert [
        streams[level] for level in (TOP, FINE_SMOOTHED, PARTNER, MIDDLE, MIDDLE_PARTNER, SLIDE)
    ] == [
        TOP,
        FINE_SMOOTHED,
        PARTNER,
        MIDDLE,
        MIDDLE_PARTNER,
        SLIDE,
    ]


def test_pictures_are_of_the_finest_level_in_the_run_s_cell(numerics):
    assert (numerics.picture("capped"), numerics.picture("smoothed")) == (PARTNER, FINE_SMOOTHED)
    assert (numerics.parts("capped"), numerics.parts("smoothed")) == (4, 1)


def test_rectangular_cells_keep_their_sides():
    levels = (Level("elastic", (64, 32), 5e4), Level("elastic", (64, 32), 1e5, "half"))
    numerics = Numerics(levels, (SIDE, SIDE / 2))
    assert numerics.grid_below(1) == Grid((32, 16), (SIDE / 2, SIDE / 4))


def test_numerics_survive_their_json(numerics):
    for one in (
        numerics,
        replace(numerics, slid_distance=np.inf),
        replace(numerics, slid_distance=1e-3),
    ):
        assert Numerics.from_dict(one.to_dict()) == one


def test_a_notebook_shows_what_each_level_corrects(numerics):
    shown = numerics._repr_html_()
    assert f"the pixel of level {LOWEST}" in shown
    assert f">level {MIDDLE}<" in shown
    assert "frozen contact, 3 realizations" in shown


LOW = Level("capped", (64, 64), 5e4)


@pytest.mark.filterwarnings("ignore:q_min = :RuntimeWarning")
@pytest.mark.parametrize(("factor", "has_waves"), [(0.999, False), (1.001, True)])
def test_a_cut_off_is_accepted_from_the_first_wave_of_its_cell_on(factor, has_waves):
    q_max = factor * np.pi / SIDE
    spectrum = rs.SelfAffineSpectrum.from_rms_height(1e-6, hurst=0.8, q_min=1.0, q_max=q_max)
    heights = rs.synthesize(spectrum, Grid((64, 64), (SIDE, SIDE)), np.random.default_rng(1))
    assert bool(heights.any()) == has_waves
    with nullcontext() if has_waves else pytest.raises(rs.ResolutionError, match="leaves no wave"):
        Numerics((replace(LOW, q_max=q_max),), (SIDE, SIDE))
