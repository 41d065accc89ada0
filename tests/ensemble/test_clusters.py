"""Many processes on one run: arrays of plain processes under kills, dask, MPI and Ray; the same bits from all."""

import importlib.util
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from process_cases import begin_process
from stored_cases import count_members, read_member
from storms import Storm

import roughsim as rs

ROOT = Path(__file__).parents[2]
ARRAY = """
import sys, time
import roughsim as rs
from roughsim.ensemble import sources, tasks
from roughsim.store import claims

claims.LEASE, claims.RENEWAL, tasks.PAUSE, tasks.BATCH, tasks.INTERVAL = 3.0, 0.2, 0.05, 0.0, 0.0
genuine = sources.solve_problem
sources.solve_problem = lambda *rest: (time.sleep(0.1), genuine(*rest))[1]  # so that kills come in the middle
rs.run(rs.load_scene(sys.argv[1]), sys.argv[2], max_realizations=int(sys.argv[3]), until={})
"""
UNGUARDED = """
import sys
import roughsim as rs

rs.run(rs.load_scene(sys.argv[1]), sys.argv[2], max_realizations=20_000, until={}, workers=2)
"""
MPI = """
import sys
from mpi4py.futures import MPIPoolExecutor
import roughsim as rs

if __name__ == "__main__":
    with MPIPoolExecutor() as executor:
        rs.run(rs.load_scene(sys.argv[1]), sys.argv[2], max_realizations=6, until={}, executor=executor, workers=2)
"""


@pytest.fixture
def scene_file(quick, tmp_path):
    (tmp_path / "scene.toml").write_text(quick.to_toml())
    return tmp_path / "scene.toml"


def script(scene_file, text, *words, before=(), **options):
    """Start a script on a scene."""
    path = scene_file.with_name("go.py")
    path.write_text(text)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    words = (*(before or [sys.executable]), path, scene_file, *words)
    return begin_process(words, env=environment, text=True, stderr=subprocess.PIPE, **options)


def assert_same_bits(folder, scene, alone, count):
    expected = rs.run(scene, alone, max_realizations=count, until={})
    found = rs.open_run(folder)
    assert found.counts == expected.counts
    assert found.realizations == count
    assert set(found.members) >= set(expected.members)  # some may have been computed ahead
    for key in expected.members:
        mine, theirs = (read_member(place, *key) for place in (folder, alone))
        for one, other in zip(mine.moments, theirs.moments, strict=True):
            for name in other.numbers:
                np.testing.assert_array_equal(one.numbers[name], other.numbers[name])
            np.testing.assert_array_equal(one.spectrum, other.spectrum)
    there = {path.name for path in folder.iterdir()}
    # no claim, nothing half done
    assert there == {"fields", "members", "members.h5", "run.json", "scene.toml"}
    assert list((folder / "members").iterdir()) == []


@pytest.mark.slow
@pytest.mark.filterwarnings(
    "ignore:.*multi-threaded:DeprecationWarning"
)  # fork: its threads have ended
@pytest.mark.parametrize("verb", ["run", "press"])
@pytest.mark.parametrize("mode", ["one writer", "two workers", "three processes"])
def test_a_storm_of_kills_changes_no_bit(tmp_path, verb, mode):
    tally = Storm(tmp_path, verb, mode).rage(int(os.environ.get("ROUGHSIM_KILLS", "3")))
    assert max(tally.between) > 0


@pytest.mark.slow
def test_suspended_processes_delay_an_array_and_change_no_bit(quick, scene_file, tmp_path):
    folder, count, rng = tmp_path / "run", 60, random.Random(3)
    array = [script(scene_file, ARRAY, folder, count) for _ in range(2)]
    for _ in range(4):
        time.sleep(rng.uniform(0.5, 2.0))
        array[0].send_signal(rng.choice([signal.SIGSTOP, signal.SIGCONT]))
    array[0].send_signal(signal.SIGCONT)
    for process in array:
        _, said = process.communicate(timeout=200)
        assert process.returncode == 0, said
    assert_same_bits(folder, quick, tmp_path / "alone", count)


@pytest.mark.slow
def test_levels_in_half_the_cell_have_the_same_bits_after_a_kill_in_the_middle(
    capped_scene, tmp_path
):
    half = {"column": "capped", "shape": [64, 64], "q_max": 1e5, "cell": "half"}
    levels = ({"column": "capped", "shape": [64, 64], "q_max": 5e4}, half)
    scene = replace(capped_scene, numerics=replace(capped_scene.numerics, levels=levels))
    folder, count = tmp_path / "run", 24
    (tmp_path / "scene.toml").write_text(scene.to_toml())
    array = [script(tmp_path / "scene.toml", ARRAY, folder, count) for _ in range(3)]

    def stored():
        return count_members(folder)

    while stored() < 8:
        assert any(one.poll() is None for one in array), array[0].communicate()[1]
        time.sleep(0.01)
    # one that computes a member now
    at_work = []
    while not at_work and any(one.poll() is None for one in array):
        claims = []
        for path in (folder / "claims").glob("L*"):
            with suppress(FileNotFoundError):  # its member has been stored meanwhile
                claims.append(path.read_text())
        at_work = [one for one in array if any(f"-{one.pid}-" in claim for claim in claims)]
    victim = at_work[0]
    victim.kill()
    victim.communicate()
    before = stored()
    assert 8 <= before < 25
    array[array.index(victim)] = script(tmp_path / "scene.toml", ARRAY, folder, count)
    for process in array:
        _, said = process.communicate(timeout=200)
        assert process.returncode == 0, said
    assert before <= stored()
    assert_same_bits(folder, scene, tmp_path / "alone", count)


@pytest.mark.slow
def test_processes_that_start_at_once_on_a_planned_scene_take_one_plan(tmp_path):
    (tmp_path / "scene.toml").write_text((ROOT / "roughsim" / "scenes" / "demo.toml").read_text())
    text = "import sys, roughsim as rs\nrs.run(rs.load_scene(sys.argv[1]), sys.argv[2], max_realizations=2, until={})"
    array = [script(tmp_path / "scene.toml", text, tmp_path / "run") for _ in range(3)]
    for process in array:
        _, said = process.communicate(timeout=200)
        assert process.returncode == 0, said
    assert rs.open_run(tmp_path / "run").realizations == 2


@pytest.mark.slow
def test_a_script_without_a_guard_ends_at_once_with_one_error(scene_file, tmp_path):
    _, said = script(scene_file, UNGUARDED, tmp_path / "run").communicate(timeout=200)
    assert "bootstrapping phase" in said  # the error of multiprocessing in a worker
    assert said.splitlines()[-1].startswith("RuntimeError: no worker could start (")
    assert '`if __name__ == "__main__":`' in said.splitlines()[-1]


@pytest.mark.slow
@pytest.mark.parametrize("reader", ["full", "gone"])
def test_a_full_or_closed_terminal_stops_no_run(scene_file, tmp_path, reader):
    folder = tmp_path / "run"
    rs.run(rs.load_scene(scene_file), folder, max_realizations=1)
    path = folder / "members.h5"
    path.write_bytes(path.read_bytes()[:-1])  # worth a warning
    words = [
        sys.executable,
        "-m",
        "roughsim",
        "run",
        scene_file,
        "-o",
        folder,
        "--workers",
        "1",
        "--max",
        "14",
    ]
    environment = os.environ | {
        "PYTHONPATH": str(ROOT),
        "PYTHONUNBUFFERED": "",
    }  # buffers are written at the end too
    if reader == "full":
        with open("/dev/full", "w") as full:
            done = subprocess.run(words, env=environment, stderr=full, check=False)
    else:
        process = begin_process(words, env=environment, stderr=subprocess.PIPE)
        process.stderr.close()
        process.wait(timeout=200)
        done = process
    assert done.returncode == 0
    assert rs.open_run(folder).realizations == 14


@pytest.mark.slow
def test_a_scheduler_of_dask_that_dies_ends_the_run_with_a_sentence(quick, tmp_path):
    distributed = pytest.importorskip("distributed", reason="the extra dask is not installed")
    options = {
        "n_workers": 1,
        "threads_per_worker": 1,
        "processes": False,
        "dashboard_address": None,
    }
    cluster = distributed.LocalCluster(**options)
    client = distributed.Client(cluster)

    def end(run):
        if run.realizations == 2:
            cluster.close()

    executor = client.get_executor(pure=False)
    with pytest.raises(RuntimeError, match="its scheduler or its workers have ended"):
        rs.run(
            quick,
            tmp_path / "run",
            max_realizations=100,
            until={},
            executor=executor,
            workers=2,
            observer=end,
        )
    client.close()
    assert rs.run(quick, tmp_path / "run", max_realizations=4, until={}).realizations == 4


@pytest.mark.slow
def test_mpi_gives_the_same_bits(quick, scene_file, tmp_path):
    if shutil.which("mpiexec") is None or importlib.util.find_spec("mpi4py") is None:
        pytest.skip("mpiexec or the extra mpi is not installed")
    before = ["mpiexec", "-n", "3", sys.executable, "-m", "mpi4py.futures"]
    process = script(scene_file, MPI, tmp_path / "run", before=before)
    _, said = process.communicate(timeout=200)
    assert process.returncode == 0, said
    assert_same_bits(tmp_path / "run", quick, tmp_path / "alone", 6)


@pytest.mark.slow
def test_ray_gives_the_same_bits(quick, tmp_path):
    ray = pytest.importorskip("ray", reason="ray is not installed")

    class RayExecutor(Executor):
        def submit(self, function, *arguments):
            return ray.remote(function).remote(*arguments).future()

    ray.init(num_cpus=2, include_dashboard=False)
    try:
        rs.run(
            quick, tmp_path / "run", max_realizations=6, until={}, executor=RayExecutor(), workers=2
        )
    finally:
        ray.shutdown()
    assert_same_bits(tmp_path / "run", quick, tmp_path / "alone", 6)
