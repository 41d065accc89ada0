"""docs/validity.md prints what the shipped map holds: each of its figures that the map can tell is computed anew."""

from dataclasses import replace
from math import nan
from pathlib import Path

import numpy as np
import pytest

import roughsim as rs
from roughsim.comparison.trust import trust
from roughsim.comparison.validity_map import read_validity

PAGE = " ".join((Path(__file__).parents[2] / "docs" / "validity.md").read_text().split())
MAP = read_validity()
ELASTIC, CAPPED = MAP["elastic"], MAP["capped"]


def column(table, name, peclet=nan):
    (k,) = (
        k
        for k, (n, pe) in enumerate(table.quantities)
        if n == name and (pe == peclet or np.isnan(pe) == np.isnan(peclet) == 1)
    )
    return k


def elastic(name, peclet=nan, rows=slice(None)):
    """Measured/theory."""
    return ELASTIC.value[rows, column(ELASTIC, name, peclet)]


def high(ratio):
    """Theory/measured − 1 in %, least and most."""
    return 100 / ratio.max() - 100, 100 / ratio.min() - 100


def test_the_elastic_map_in_short():
    heavy, light = (ELASTIC.place[:, 0] == load for load in (0.6, 0.002))
    slow, fast = (elastic("flash_temperature", pe) for pe in (1e-3, 1e3))
    assert (
        "by {:.0f} to {:.0f} % near full contact and {:.0f} to {:.0f} % under".format(
            *high(slow[heavy]), *high(slow[light])
        )
        in PAGE
    )
    assert f"too cool by up to {-high(fast)[0]:.0f} %" in PAGE
    assert max(np.abs(high(fast[heavy]))) < 1.0  # "within 1 % near full contact"
    assert f"from {-high(fast[light])[0]:.0f} % too cool to {high(fast[light])[1]:.0f} % too hot under" in PAGE
    widths = [1 / elastic(name, 10.0**k).min() for name in ("flash_width", "slope_length") for k in range(-3, 4)]
    assert f"too large by a factor of up to {max(widths):.0f}" in PAGE
    area, variance = elastic("contact_fraction"), elastic("pressure_variance")
    assert f"contact area is {100 * area.min() - 100:.0f} to {100 * area.max() - 100:.0f} % larger" in PAGE
    assert f"up to {100 * variance.max() - 100:.0f} % larger than the theory's" in PAGE


def test_the_errors_of_the_elastic_map():
    worst = [
        100 * max(ELASTIC.error[:, k].max() for k, (n, _) in enumerate(ELASTIC.quantities) if n == name)
        for name in ("flash_temperature", "pressure_variance", "flash_width")
    ]
    assert "error is at most {:.1f} % for T_flash, {:.1f} % for g_σ(0), {:.1f} % for D_flash".format(*worst) in PAGE
    assert f"{len(ELASTIC.place)} contacts" in PAGE


def test_what_changes_at_the_ends_of_the_peclet_numbers():
    names = ("flash_temperature", "flash_gradient", "flash_width", "slope_length")
    slow = [100 * max(abs(elastic(n, pe) / elastic(n, 0.1) - 1).max() for pe in (1e-3, 1e-2)) for n in names]
    fast = [100 * abs(elastic(n, 1e3) / elastic(n, 1e2) - 1).max() for n in names]
    assert "change by at most {:.1f}, {:.1f}, {:.1f} and {:.1f} %".format(*slow) in PAGE
    assert "still change, by up to {:.0f}, {:.0f}, {:.0f} and {:.0f} %".format(*fast) in PAGE


def test_what_a_straight_line_over_the_peclet_number_misses():
    logs = np.log([elastic("flash_temperature", 10.0**k) for k in range(-3, 4)])
    missed = 100 * np.abs(logs[1:-1] - (logs[:-2] + logs[2:]) / 2).max() / 4  # every other point left out, over four
    assert f"the most in the Péclet number is {missed:.1f} %" in PAGE


def limits(name, peclet, rows=slice(None)):
    table = MAP[name]
    where = np.isinf(table.place[:, -1]) if name == "capped" else np.full(len(table.place), True)
    values = table.value[where, column(table, "flash_temperature", peclet)]
    return values.min(), values.max()


def test_the_capped_map():
    assert (
        "slow T_flash {:.2f} to {:.2f} of the theory, fast {:.2f} to {:.2f}".format(
            *limits("smoothed", 1e-3), *limits("smoothed", 1e3)
        )
        in PAGE
    )
    slow, fast = (limits("steps", pe) for pe in (1e-3, 1e3))
    assert "slow {:.2f} to {:.2f}, fast {:.2f} to {:.2f}. Small H".format(*slow, *fast) in PAGE
    cooler = [100 * (1 - x) for x in (fast[1], fast[0], slow[1], slow[0])]
    assert "by {:.0f} to {:.0f} % in fast and {:.0f} to {:.0f} % in slow sliding".format(*cooler) in PAGE
    assert (
        "capped over theory: slow {:.2f} to {:.2f}, fast {:.2f} to {:.2f}".format(
            *limits("capped", 1e-3), *limits("capped", 1e3)
        )
        in PAGE
    )
    finite = np.isfinite(CAPPED.place[:, 5])
    assert f"errors are at most {100 * CAPPED.error[finite, :7].max():.1f} %" in PAGE


@pytest.mark.parametrize("hurst", [0.3, 0.55, 0.8])
def test_where_c_ends(hurst):
    cells = []
    grid = (CAPPED.place[:, 2] == hurst) & (CAPPED.place[:, 3] == 2.0)
    ends = CAPPED.place[:, 5]
    for depth in (4.0, 8.0, 16.0, 32.0, 64.0):
        excess = [
            CAPPED.value[row, :7] / CAPPED.value[same, :7] - 1
            for row in np.flatnonzero(grid & (ends == depth))
            for same in np.flatnonzero(np.isinf(ends) & (CAPPED.place[:, :5] == CAPPED.place[row, :5]).all(axis=1))
        ]
        assert len(excess) == 10
        cells.append(f"{100 * np.min(excess):.0f} … {100 * np.max(excess):.0f}")
    assert f"| H = {hurst:g} | {' | '.join(cells)} |" in PAGE


def test_what_a_straight_line_in_h_would_miss():
    missed = {}
    for row in np.flatnonzero(CAPPED.place[:, 2] == 0.55):
        at = [
            np.flatnonzero((CAPPED.place == [*CAPPED.place[row, :2], h, *CAPPED.place[row, 3:]]).all(axis=1))
            for h in (0.3, 0.8)
        ]
        low, far = (np.log(CAPPED.value[k[0], :7]) for k in at)
        missed.setdefault(CAPPED.place[row, 5], []).append(100 * (np.log(CAPPED.value[row, :7]) - (low + far) / 2))
    assert "misses the limit at H = 0.55 by {:.0f} to {:.0f} %".format(*_range(missed[np.inf])) in PAGE
    assert "at q_max = 8 q_y by {:.0f} to {:.0f} %".format(*_range(missed[8.0])) in PAGE


def _range(values):
    return np.min(values), np.max(values)


def test_the_bundled_scenes():
    judged = [str(j).removesuffix(" high") for j in trust(rs.load_scene("demo")).judgements[:3]]
    assert (
        f"the map says {judged[0]}, {judged[1]} and {judged[2]}".replace(" %,", ",").replace(" % and", " and") in PAGE
    )
    steels = []
    for name in ("steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa"):
        scene = rs.load_scene(name)
        scene = replace(scene, sliding=replace(scene.sliding, speed=(35.0,)))
        steels += [trust(replace(scene, theory=replace(scene.theory, gamma=g))).judgements[0] for g in (0.294, 0.45)]
    assert "theory is {:.0f}, {:.0f} and {:.0f} % high at".format(*(j.percent for j in steels[1::2])) in PAGE
    words = [str(j).removesuffix(" % high") for j in steels[::2]]
    assert f"it is {words[0]}, {words[1]} and {words[2]} % high" in PAGE
