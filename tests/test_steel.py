"""The steel scenes at full size: slow, and compared with what an independent prototype measured."""

import numpy as np
import pytest

import roughsim as rs
from roughsim.scene.numerics import Level, Numerics

pytestmark = pytest.mark.slow


def test_the_main_job_measures_what_an_independent_program_measured(tmp_path):
    # smoothed 391 ± 4 K, capped → about 211 K at 35 m/s (another solver, other surfaces, no pixel correction)
    run = rs.run(
        rs.load_scene("steel-1.2GPa"), tmp_path / "run", max_realizations=12, until={}, workers=2
    )
    row = next(
        r for r in rs.compare(run).rows if r.observable == "flash_temperature" and r.speed == 35.0
    )
    smoothed, capped = row.columns["smoothed"], row.columns["capped"]
    assert row.theory == pytest.approx(258.9, rel=0.002)
    assert abs(smoothed.mean - 391.0) < 4 * np.hypot(4.0, smoothed.standard_error)
    assert capped.mean == pytest.approx(211.0, rel=0.03)
    assert capped.mean + capped.bias == pytest.approx(218.0, rel=0.02)  # its finest level: 218 ± 2


def test_capped_flash_temperature_falls_as_one_over_the_cut_off():
    scene = rs.load_scene("steel-0.5GPa")
    lengths = rs.plan(scene).lengths
    # 4 pixels per shortest wave, from 8 q_y on
    levels = tuple(
        Level("capped", (n, n), n * 2 * np.pi / (4 * lengths[0])) for n in (256, 512, 1024)
    )
    numerics = Numerics(levels, lengths)
    rows = [
        [
            rs.realize(scene, numerics, seed=1, level=k, index=i).observables.flash_temperature[5]
            for k in range(3)
        ]
        for i in range(3)
    ]
    a, b, c = np.mean(rows, axis=0)
    assert np.log2((a - b) / (b - c)) == pytest.approx(1.0, abs=0.3)
    assert 2 * c - b == pytest.approx(2 * b - a, rel=0.03)
