"""The slope of the stress spectrum in its band: exact in full contact, and told with a statistical error."""

from dataclasses import replace

import numpy as np
import pytest
from damage_cases import forged

import roughsim as rs
from roughsim.comparison.slope import stress_slope


@pytest.fixture(scope="module")
def full(full_scene, tmp_path_factory):
    """Full contact: |σ_q|² = (E* q/2)² C(q) ∝ q^(−2H) in every realization."""
    return rs.run(full_scene, tmp_path_factory.mktemp("full") / "run", max_realizations=2)


def test_in_full_contact_the_slope_is_that_of_the_roughness(full):
    found = stress_slope(full)
    assert found.measured == pytest.approx(-2 * 0.8, abs=0.02)  # modes near q_min are wide
    assert found.theory == pytest.approx(-2 * 0.8, abs=1e-6)
    assert found.error == pytest.approx(0.0, abs=1e-9)
    assert (found.column, found.low, found.high) == ("elastic", 6283.1853, 1e5)


def test_a_band_that_yielding_leaves_no_room_for_has_no_slope(capped_run):
    assert stress_slope(capped_run, "capped") is None
    assert rs.compare(capped_run).slopes == ()


def test_the_error_of_the_slope_is_the_scatter_of_the_realizations(full_scene, tmp_path):
    tilts = np.array([-0.05, 0.01, 0.04])
    run = rs.run(full_scene, tmp_path / "run", max_realizations=3)
    with forged(run.folder / "members.h5") as file:
        q = file["L0/wavenumber"][:]
        file["L0/stress_spectrum"][...] *= ((q / q[0]) ** tilts[:, None])[:, None]
    flat = -2 * 0.8
    found = stress_slope(rs.open_run(run.folder))
    assert found.measured == pytest.approx(flat + tilts.mean(), abs=0.02)
    student = 4.3026527 * np.sqrt(
        1 + 2 / 2
    )  # 2 degrees of freedom, widened for runs that stop themselves
    assert found.error == pytest.approx(student * tilts.std(ddof=1) / np.sqrt(3), rel=0.1)


def test_the_slope_stands_under_the_table_and_in_the_json(full):
    table = rs.compare(full)
    line = table.table().notes[0]
    assert line.startswith("slope of |σ_q|² from 6.28e+03 to 1e+05 rad/m: elastic -1.58")
    assert line.endswith("(statistical, 95 %), theory -1.60")
    (told,) = table.to_dict()["stress_slopes"]
    assert told == stress_slope(full)._asdict()


def test_the_slope_of_one_realization_has_an_unknown_error(full, full_scene, tmp_path):
    one = rs.run(full_scene, tmp_path / "run", max_realizations=1)

    class OfOneRealization(type(rs.compare(full))):
        slopes = (stress_slope(one),)

    alone = OfOneRealization(full)
    assert "± unknown (statistical" in alone.table().notes[0]
    assert alone.to_dict()["stress_slopes"][0]["error"] is None  # JSON has no infinity


@pytest.mark.slow
@pytest.mark.parametrize(("hurst", "measured"), [(0.3, -1.09), (0.5, -1.30), (0.8, -1.67)])
def test_the_slope_of_light_contact_is_flatter_than_the_theory(
    full_scene, tmp_path, hurst, measured
):
    keys = {
        "rms_height": None,
        "rms_slope": 0.1,
        "hurst": hurst,
        "q_min": 2.5e4,
        "q_roll_off": 1e5,
        "q_max": 3.2e6,
    }
    body = replace(full_scene.body, youngs_modulus=2e11)
    scene = replace(
        full_scene,
        surface=replace(full_scene.surface, **keys),
        body=body,
        sliding=replace(full_scene.sliding, nominal_pressure=4.4e8),
        numerics=replace(
            full_scene.numerics,
            lengths=(16 * np.pi / 1e5,) * 2,
            tolerance=1e-4,
            levels=({"column": "elastic", "shape": [1024, 1024], "q_max": 3.2e6},),
        ),
    )
    found = stress_slope(rs.run(scene, tmp_path / "run", max_realizations=3, workers=1))
    assert found.measured == pytest.approx(measured, abs=0.05)
    assert found.theory < -(1 + hurst) < found.measured
