"""Ensembles: members by name, the same bits however they are computed, resuming, failing, stopping."""

import json
import os
import subprocess
import sys
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from stored_cases import member_path, read_member, split_members, write_member

import roughsim as rs

ROOT = Path(__file__).parents[2]


def numbers(folder, level, index):
    return read_member(folder, level, index).numbers


def assert_same(first, second, levels, count):
    for level in range(levels):
        for index in range(count):
            a, b = numbers(first, level, index), numbers(second, level, index)
            for name in a:
                np.testing.assert_array_equal(a[name], b[name], err_msg=name)


def test_a_member_is_named_by_level_and_index(capped_scene, capped_run):
    numerics = rs.plan(capped_scene)
    one = rs.realize(capped_scene, numerics, seed=3, level=1, index=2)
    stored = numbers(capped_run.folder, 1, 2)
    np.testing.assert_array_equal(one.observables.flash_temperature, stored["flash_temperature"])
    assert one.contact.contact_fraction == stored["contact_fraction"][0]


def test_a_member_is_the_surface_of_its_stream(capped_scene):
    numerics = rs.plan(capped_scene)
    one = rs.realize(capped_scene, numerics, seed=3, level=2, index=5)
    stream = np.random.default_rng(np.random.SeedSequence(3, spawn_key=(2, 5)))
    spectrum = capped_scene.spectrum.truncated(q_max=1e5)
    np.testing.assert_array_equal(one.heights, rs.synthesize(spectrum, numerics.grid(2), stream))


def test_the_lowest_levels_of_both_columns_see_the_same_modes_and_a_higher_one_its_own(
    capped_scene,
):
    numerics = rs.plan(capped_scene)
    smooth, coarse, fine = (
        rs.realize(capped_scene, numerics, seed=3, level=k, index=0).heights for k in range(3)
    )
    modes = [np.fft.fft2(heights) / heights.size for heights in (smooth, coarse, fine)]
    low = (slice(0, 8), slice(0, 8))
    q = numerics.grid(0).wavenumbers[low]
    inside = (q > 6350 * 1.5) & (q < 2e4)
    phases = [np.angle(one[low][inside] / modes[1][low][inside]) for one in modes]
    np.testing.assert_allclose(phases[0], 0.0, atol=1e-10)
    assert np.abs(phases[2]).min() > 1e-3


def test_each_level_solves_what_its_column_says(capped_scene):
    from theory import plasticity

    numerics = rs.plan(capped_scene)
    smooth, coarse, fine = (
        rs.realize(capped_scene, numerics, seed=3, level=k, index=0) for k in range(3)
    )
    assert smooth.contact.pressure.max() > 1e9  # elastic: above the hardness
    assert coarse.contact.pressure.max() == fine.contact.pressure.max() == 1e9
    pressures = {
        "effective_modulus": 1 / (2 * 0.91 / 200e9),
        "nominal_pressure": 9e7,
        "penetration_hardness": 1e9,
    }
    drawn = {
        0: plasticity.smoothed_spectrum(capped_scene.spectrum, **pressures),
        1: capped_scene.spectrum,
        2: capped_scene.spectrum,
    }
    for level, one in enumerate((smooth, coarse, fine)):
        q = np.linspace(6350, numerics.levels[level].q_max, 20001)
        variance = np.trapezoid(2 * np.pi * q * drawn[level](q), q)
        assert one.heights.var() == pytest.approx(variance, rel=0.03)  # a cell of two longest waves
        assert one.contact.residual <= 1e-4
        assert one.contact.pressure.mean() == pytest.approx(9e7)


def test_the_smoothed_surface_is_drawn_from_the_smoothed_spectrum(capped_scene):
    # same phases, same modes: the power of each mode falls by the factor of Eq. (27)
    from theory import plasticity

    numerics = rs.plan(capped_scene)
    power = [
        np.abs(np.fft.rfft2(rs.realize(capped_scene, numerics, seed=3, level=k, index=0).heights))
        ** 2
        for k in (0, 1)
    ]
    q = numerics.grid(0).wavenumbers
    ring = (q > 4.2e4) & (q < 4.8e4)
    pressures = {
        "effective_modulus": 1 / (2 * 0.91 / 200e9),
        "nominal_pressure": 9e7,
        "penetration_hardness": 1e9,
    }
    smooth = plasticity.smoothed_spectrum(capped_scene.spectrum, **pressures)
    factor = smooth(q[ring]) / capped_scene.spectrum(q[ring])
    assert factor.max() < 0.999
    np.testing.assert_allclose(
        power[0][ring] / power[1][ring], factor, atol=0.1 * (1 - factor.min())
    )


def test_the_correlation_starts_at_the_variance_of_the_lowest_level_and_the_step(capped_run):
    mean, error = capped_run.correlation(np.array([0.0, 1e-5]))
    lowest = np.array([numbers(capped_run.folder, 1, i)["pressure_variance"][0] for i in range(6)])
    fine = [read_member(capped_run.folder, 2, i).moments for i in range(6)]
    step = np.array(
        [
            (own.numbers["pressure_variance"] - below.numbers["pressure_variance"])[0]
            for own, below in fine
        ]
    )
    assert mean[0] == pytest.approx(lowest.mean() + step.mean(), rel=1e-9)
    assert error[0] == pytest.approx(np.sqrt((lowest.var(ddof=1) + step.var(ddof=1)) / 6), rel=1e-6)
    assert mean[1] < mean[0]
    with pytest.raises(ValueError, match="exceeds half the diagonal of the cell"):
        capped_run.correlation(np.array([1.0]))


@pytest.mark.slow
def test_two_workers_threads_and_a_pool_of_processes_give_the_same_bits(
    capped_scene, capped_run, tmp_path
):
    shared = rs.run(capped_scene, tmp_path / "two", workers=2)
    assert_same(shared.folder, capped_run.folder, 3, 6)
    with ThreadPoolExecutor(2) as pool:
        threaded = rs.run(capped_scene, tmp_path / "threads", executor=pool)
    assert_same(threaded.folder, capped_run.folder, 3, 6)
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        spawned = rs.run(capped_scene, tmp_path / "processes", executor=pool, workers=2)
    assert_same(spawned.folder, capped_run.folder, 3, 6)
    np.testing.assert_array_equal(
        shared.estimate("flash_temperature").mean, capped_run.estimate("flash_temperature").mean
    )


@pytest.mark.slow
def test_dask_gives_the_same_bits(quick, tmp_path):
    distributed = pytest.importorskip("distributed", reason="the extra dask is not installed")
    alone = rs.run(quick, tmp_path / "alone", max_realizations=4)
    options = {
        "n_workers": 2,
        "threads_per_worker": 1,
        "host": "127.0.0.1",
        "dashboard_address": None,
    }
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        executor = client.get_executor(pure=False)
        shared = rs.run(quick, tmp_path / "dask", max_realizations=4, executor=executor, workers=2)
    assert_same(alone.folder, shared.folder, 1, 4)


def test_a_run_goes_on_where_it_stopped(capped_scene, capped_run, tmp_path):
    rs.run(capped_scene, tmp_path / "run", max_realizations=2)
    member_path(split_members(tmp_path / "run"), 1, 1).unlink()  # as if killed between two levels
    stored = read_member(tmp_path / "run", 2, 1)
    old = replace(stored, provenance=stored.provenance | {"written": "long ago"})
    write_member(tmp_path / "run", old)
    resumed = rs.run(capped_scene, tmp_path / "run")
    assert read_member(tmp_path / "run", 2, 1).provenance["written"] == "long ago"
    assert resumed.realizations == 6
    assert_same(tmp_path / "run", capped_run.folder, 3, 6)


def test_a_damaged_member_is_done_again_with_a_warning(capped_scene, capped_run, tmp_path):
    rs.run(capped_scene, tmp_path / "run", max_realizations=2)
    path = member_path(split_members(tmp_path / "run"), 1, 1)
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.warns(RuntimeWarning, match="L1-000001.h5 is damaged"):
        rs.run(capped_scene, tmp_path / "run", max_realizations=2)
    assert_same(tmp_path / "run", capped_run.folder, 3, 2)


def test_a_changed_scene_is_refused_naming_the_key(quick, tmp_path):
    rs.run(quick, tmp_path / "run", max_realizations=1)
    changed = replace(quick, sliding=replace(quick.sliding, friction_coefficient=0.2))
    with pytest.raises(
        rs.RecordError, match=r"sliding.friction_coefficient is 0.11 there and 0.2 here"
    ):
        rs.run(changed, tmp_path / "run")
    with pytest.raises(rs.RecordError, match="ensemble.seed is 3 there and 4 here"):
        rs.run(quick, tmp_path / "run", seed=4)
    finer = replace(rs.plan(quick), tolerance=1e-5)
    with pytest.raises(rs.RecordError, match="tolerance is 0.0001 there and 1e-05 here"):
        rs.run(quick, tmp_path / "run", numerics=finer)
    # these are not the scene: more realizations, another target, more fields, another title
    again = rs.run(
        replace(quick, title="other"),
        tmp_path / "run",
        max_realizations=3,
        until={"flash_temperature": 0.5},
    )
    assert again.realizations == 3


@pytest.mark.slow
def test_it_stops_at_the_target_with_the_same_members_for_any_workers(tmp_path):
    goal = {"flash_temperature": 0.004}
    alone = rs.run(rs.load_scene("demo"), tmp_path / "alone", until=goal, max_realizations=200)
    shared = rs.run(
        rs.load_scene("demo"), tmp_path / "shared", until=goal, max_realizations=200, workers=2
    )
    assert 12 < alone.realizations < 200
    assert alone.target_met
    assert shared.counts == alone.counts
    estimates = [run.estimate("flash_temperature") for run in (alone, shared)]
    np.testing.assert_array_equal(estimates[0].mean, estimates[1].mean)
    assert np.all(estimates[0].total_error <= 0.004 * estimates[0].mean)


def test_a_target_out_of_reach_ends_and_says_why(quick, tmp_path):
    run = rs.run(quick, tmp_path / "run", until={"flash_temperature": 1e-9}, max_realizations=13)
    assert run.finished
    assert not run.target_met
    assert run.rounds.verdict.why.startswith("out of reach")


def test_a_lower_target_goes_on_and_a_higher_one_stops_at_an_earlier_round(quick, tmp_path):
    most = rs.run(quick, tmp_path / "run", until={}, max_realizations=40)
    assert most.realizations == 40
    fewer = rs.run(quick, tmp_path / "run", until={}, max_realizations=20)
    assert (fewer.realizations, fewer.estimate("flash_temperature").n) == (20, 20)
    assert fewer.finished
    assert not fewer.missing
    longer = rs.run(quick, tmp_path / "run", until={}, max_realizations=41)
    assert longer.counts == (41,)


@pytest.mark.slow
def test_a_planned_run_goes_on_with_what_it_began_with(tmp_path, calls):
    from roughsim.ensemble import run as ensemble_run

    scene = rs.load_scene("demo")
    began = rs.run(scene, tmp_path / "run", max_realizations=2, until={})
    planned = calls(ensemble_run, "numerics_of")
    run = rs.run(scene, tmp_path / "run", max_realizations=3, until={"flash_temperature": 1e-4})
    assert run.realizations == 3
    assert run.numerics == began.numerics
    assert run.reasons == began.reasons != ()
    assert planned == []


def test_a_run_that_goes_on_may_keep_more_fields(quick, tmp_path):
    rs.run(quick, tmp_path / "run", max_realizations=1)
    more = replace(quick, numerics=replace(quick.numerics, keep_fields=2))
    assert rs.run(more, tmp_path / "run", max_realizations=3).kept(0) == [0, 1]
    most = replace(rs.plan(quick), keep_fields=4)
    assert rs.run(quick, tmp_path / "run", numerics=most, max_realizations=4).kept(0) == [0, 1, 3]


def test_members_that_do_not_converge_are_counted_and_left_out(quick, tmp_path, failing):
    failing(lambda problem: problem.index == 1)
    run = rs.run(quick, tmp_path / "run", max_realizations=4)
    assert (run.realizations, run.failed) == (4, 1)
    assert run.estimate("flash_temperature").n == 3
    assert "stalled" in read_member(run.folder, 0, 1).failure
    assert rs.compare(run).to_dict()["failed"] == 1


def test_an_executor_that_takes_no_more_members_ends_the_run_with_a_sentence(
    quick, tmp_path, one_by_one
):
    taken = []

    class Closing(ThreadPoolExecutor):
        def submit(self, function, *arguments):
            if len(taken) == 3:
                raise OSError("client is closed")
            taken.append(arguments)
            return super().submit(function, *arguments)

    with pytest.raises(
        RuntimeError, match="OSError: client is closed.*its scheduler or its workers have ended"
    ):
        rs.run(
            quick, tmp_path / "run", max_realizations=4, until={}, executor=Closing(1), workers=1
        )
    assert not (tmp_path / "run" / "claims").exists()
    assert rs.run(quick, tmp_path / "run", max_realizations=4, until={}).realizations == 4


def test_run_json_tells_all_before_anything_slow(quick, tmp_path):
    class Never(Executor):
        def submit(self, *_):
            raise RuntimeError("not now")

    with pytest.raises(RuntimeError, match="not now"):
        rs.run(quick, tmp_path / "run", executor=Never())
    told = json.loads((tmp_path / "run" / "run.json").read_text())
    assert told["scene"]["ensemble.seed"] == 3
    assert told["scene"]["sliding.friction_coefficient"] == 0.11
    assert {"numpy", "numba", "fft", "roughsim"} <= set(told["versions"])
    assert rs.load_scene(tmp_path / "run" / "scene.toml").sliding == quick.sliding
    assert not (tmp_path / "run" / "claims").exists()


def test_fields_are_kept_for_the_first_members_only(capped_run):
    first = read_member(capped_run.folder, 2, 0)
    second = read_member(capped_run.folder, 2, 1)
    assert set(first.fields) == {"heights", "pressure"}
    assert first.fields["pressure"].shape == (128, 128)
    assert first.fields["pressure"].mean() == pytest.approx(9e7, rel=1e-5)
    assert second.fields == {}


def test_temperatures_are_those_of_the_share_used(capped_run):
    found = capped_run.estimate("flash_temperature", column="smoothed").mean
    rows = np.array([numbers(capped_run.folder, 0, i)["flash_temperature"] for i in range(6)])
    at_cut_off = capped_run.values("flash_temperature", "smoothed", extrapolated=False).finest
    np.testing.assert_allclose(at_cut_off, rows.mean(axis=0), rtol=1e-12, atol=1e-140)
    whole = capped_run.values("flash_temperature", "smoothed").value
    np.testing.assert_allclose(found, 0.9 * whole, rtol=1e-12, atol=1e-140)
    # what lies between the two is continued from q_c to q_max, 4e-6 here
    np.testing.assert_allclose(found, 0.9 * rows.mean(axis=0), rtol=1e-5, atol=1e-140)


@pytest.mark.slow
def test_a_first_compilation_gives_the_bits_of_the_cache(capped_scene, tmp_path):
    # kernels that call kernels were once inlined when compiled, but not when loaded: sums were then ordered differently
    (tmp_path / "scene.toml").write_text(capped_scene.to_toml())
    code = (
        "import sys, roughsim as rs; s = rs.load_scene(sys.argv[1]); n = rs.plan(s)\n"
        "for level in range(3):\n"
        "    for index in range(4):\n"
        "        one = rs.realize(s, n, seed=3, level=level, index=index)\n"
        "        print(one.contact.pressure.tobytes().hex()[:4000], one.observables.flash_temperature.tolist())\n"
    )
    environment = {
        **os.environ,
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
        "PYTHONPATH": str(ROOT),
    }
    words = [sys.executable, "-c", code, str(tmp_path / "scene.toml")]
    said = [
        subprocess.run(words, capture_output=True, text=True, check=True, env=environment).stdout
        for _ in range(2)
    ]
    assert len(said[0].splitlines()) == 12
    assert said[0] == said[1]
