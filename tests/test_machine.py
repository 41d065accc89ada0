"""Memory and cores of this process: the least of the machine, the control groups of versions 1 and 2, and own limits.

The trees of /proc and /sys are written here as Linux writes them; the limits of real processes are set by real ones.
"""

import os
import resource
import shutil
import subprocess
import sys
from math import inf
from pathlib import Path

import pytest

import roughsim as rs
from roughsim import machine
from roughsim.machine import Available, available_memory, usable_cores, workers_that_fit

V1_MOUNTS = """\
35 31 0:32 {top} /sys/fs/cgroup/memory rw,relatime shared:9 - cgroup cgroup rw,memory
32 31 0:29 {top} /sys/fs/cgroup/cpu,cpuacct rw,relatime - cgroup cgroup rw,cpu,cpuacct
"""
V2_MOUNT = "41 31 0:38 / /sys/fs/cgroup rw,relatime - cgroup2 cgroup2 rw,nsdelegate\n"
SYSTEM = "22 28 0:21 / /proc rw,nosuid shared:12 - proc proc rw\n"
NO_LIMIT = str(2**63 - 4096)  # of version 1


def tree(root, groups, mounts, files):
    """A root folder with 8 GB free; `files` are paths below sys/fs/cgroup with their texts."""
    (root / "proc/self").mkdir(parents=True)
    (root / "proc/meminfo").write_text("MemTotal:       16000000 kB\nMemAvailable:    8000000 kB\n")
    (root / "proc/self/cgroup").write_text(groups)
    (root / "proc/self/mountinfo").write_text(SYSTEM + mounts)
    for name, text in files.items():
        path = root / "sys/fs/cgroup" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return root


@pytest.fixture(autouse=True)
def many_cores(monkeypatch):
    monkeypatch.setattr(machine, "allowed_cores", lambda: Available(64, "allowed to this process"))


@pytest.fixture(autouse=True)
def own_limits(monkeypatch):
    """The limits of this process, bytes, by their number: none but those that a test sets."""
    limits = {}
    monkeypatch.setattr(
        resource, "getrlimit", lambda one: (limits.get(one, resource.RLIM_INFINITY), 0)
    )
    return limits


def test_without_limits_the_memory_is_what_the_machine_has_free(tmp_path):
    assert available_memory(tree(tmp_path, "", "", {})) == (8.192e9, "free on this machine")
    assert usable_cores(tmp_path) == (64, "allowed to this process")


def test_without_the_files_of_linux_it_is_all_that_the_machine_has(tmp_path):
    pages = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    assert available_memory(tmp_path) == (pages, "the memory of this machine")


def test_where_the_system_does_not_say_there_is_no_limit(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "sysconf", lambda name: (_ for _ in ()).throw(OSError))
    assert available_memory(tmp_path).amount == inf
    assert workers_that_fit(5, 1e30, "a grid", available_memory(tmp_path)) == 5


def test_a_group_of_version_1_leaves_its_limit_less_what_is_used_and_no_file(tmp_path):
    files = {
        "memory/slurm/job_7/memory.limit_in_bytes": "600000000\n",
        "memory/slurm/job_7/memory.usage_in_bytes": "250000000\n",
        "memory/slurm/job_7/memory.stat": "cache 9\ninactive_file 1\ntotal_inactive_file 50000000\n",
        "cpu,cpuacct/slurm/job_7/cpu.cfs_quota_us": "350000\n",
        "cpu,cpuacct/slurm/job_7/cpu.cfs_period_us": "100000\n",
    }
    groups = "5:memory:/slurm/job_7\n4:cpu,cpuacct:/slurm/job_7\n1:name=systemd:/\n0::/\n"
    root = tree(tmp_path, groups, V1_MOUNTS.format(top="/"), files)
    assert available_memory(root) == (400e6, "limit 0.6 GB of the control group")
    assert usable_cores(root) == (3, "limit 3.5 cores of the control group")


def test_a_group_of_version_2_leaves_its_limit_less_what_is_used_and_no_file(tmp_path):
    files = {
        "job/memory.max": "2000000000\n",
        "job/memory.high": "max\n",
        "job/memory.current": "500000000\n",
        "job/memory.stat": "anon 4\nfile 5\ninactive_file 100000000\nactive_file 7\n",
        "job/cpu.max": "250000 50000\n",
    }
    root = tree(tmp_path, "0::/job\n", V2_MOUNT, files)
    assert available_memory(root) == (1600e6, "limit 2 GB of the control group")
    assert usable_cores(root) == (5, "limit 5 cores of the control group")
    (root / "sys/fs/cgroup/job/memory.high").write_text(
        "1000000000\n"
    )  # where the system slows a group down
    assert available_memory(root) == (600e6, "limit 1 GB of the control group")


def test_the_least_of_the_groups_above_counts(tmp_path):
    files = {
        "user.slice/memory.max": "max\n",
        "user.slice/one/memory.max": "1000000000\n",
        "user.slice/one/memory.current": "300000000\n",
        "user.slice/one/two/memory.max": "3000000000\n",
        "user.slice/one/two/memory.current": "0\n",
        "user.slice/cpu.max": "200000 100000\n",
        "user.slice/one/two/cpu.max": "max 100000\n",
        "user.slice/other/memory.max": "1\n",  # not a group of this process
    }
    root = tree(tmp_path, "0::/user.slice/one/two\n", V2_MOUNT, files)
    assert available_memory(root).amount == 700e6
    assert usable_cores(root).amount == 2


@pytest.mark.parametrize("own", ["/docker/abc", "/", "/../elsewhere", "/another/abc"])
def test_in_a_container_the_group_is_where_its_part_of_the_tree_is_mounted(tmp_path, own):
    files = {
        "memory/memory.limit_in_bytes": "600000000\n",
        "memory/memory.usage_in_bytes": "0\n",
        "elsewhere/memory.limit_in_bytes": "1\n",  # beside the tree of the memory
        "cpu,cpuacct/cpu.cfs_quota_us": "100000\n",
        "cpu,cpuacct/cpu.cfs_period_us": "100000\n",
    }
    top = "/docker/abc" if own == "/docker/abc" else "/"
    root = tree(
        tmp_path, f"5:memory:{own}\n4:cpu,cpuacct:{own}\n", V1_MOUNTS.format(top=top), files
    )
    assert available_memory(root).amount == 600e6
    assert usable_cores(root).amount == 1


def test_groups_without_limits_or_files_limit_nothing(tmp_path):
    files = {
        "memory/memory.limit_in_bytes": f"{NO_LIMIT}\n",
        "memory/memory.usage_in_bytes": "5000000000\n",
        "cpu,cpuacct/cpu.cfs_quota_us": "-1\n",
        "cpu,cpuacct/cpu.cfs_period_us": "100000\n",
        "unified/cgroup.procs": "1\n",
    }
    mounts = V1_MOUNTS.format(top="/") + V2_MOUNT.replace(
        "/sys/fs/cgroup", "/sys/fs/cgroup/unified"
    )
    root = tree(tmp_path, "5:memory:/\n4:cpu,cpuacct:/absent\n0::/absent\n", mounts, files)
    assert available_memory(root) == (8.192e9, "free on this machine")
    assert usable_cores(root).amount == 64


def test_a_group_of_less_than_one_core_still_has_one_worker_and_one_that_is_full_has_no_memory(
    tmp_path,
):
    files = {"cpu.max": "50000 100000\n", "memory.max": "1000\n", "memory.current": "5000\n"}
    root = tree(tmp_path, "0::/\n", V2_MOUNT, files)
    assert usable_cores(root).amount == 1
    assert available_memory(root).amount == 0.0


@pytest.mark.parametrize(("which", "used"), [("RLIMIT_AS", 1000), ("RLIMIT_DATA", 300)])
def test_the_own_limits_count_less_what_this_process_uses(tmp_path, own_limits, which, used):
    root = tree(tmp_path, "", "", {})
    (root / "proc/self/statm").write_text("1000 500 200 10 0 300 0\n")  # pages
    own_limits[getattr(resource, which)] = 4_000_000_000
    assert available_memory(root).amount == 4e9 - used * resource.getpagesize()


# members of a worker, GB; memory, GB; processes take 0.25 GB each beside their member
@pytest.mark.parametrize(
    ("member", "memory", "workers"),
    [
        (18.0, 25.3, 1),
        (9.7, 25.3, 2),
        (9.95, 25.3, 1),
        (0.001, 25.3, 8),
        (0.1, 0.4, 1),
        (1.0, 12.5, 8),
        (1.0, 12.4, 7),
    ],
)
def test_all_members_together_take_four_fifths_of_the_memory(member, memory, workers):
    assert (
        workers_that_fit(8, member * 1e9, "largest grid", Available(memory * 1e9, "here"))
        == workers
    )


def test_a_member_that_does_not_fit_is_refused_with_numbers():
    with pytest.raises(
        rs.ResolutionError, match=r"^memory = 0.9 GB \(largest grid\) exceeds 80 % of the 1 GB "
    ):
        workers_that_fit(1, 0.9e9, "largest grid", Available(1e9, "here"))


CODE = "from roughsim.machine import *; print(usable_cores().amount, *available_memory())"


def asked(*before, **options):
    words = [*before, sys.executable, "-c", CODE]
    found = subprocess.run(
        words, capture_output=True, text=True, check=True, cwd=Path(__file__).parents[1], **options
    )
    cores, memory, source = found.stdout.split(maxsplit=2)
    return float(cores), float(memory), source.strip()


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="cores cannot be chosen")
def test_a_process_bound_to_one_core_has_one():
    one = min(os.sched_getaffinity(0))
    assert asked(preexec_fn=lambda: os.sched_setaffinity(0, {one}))[0] == 1


@pytest.mark.skipif(sys.platform != "linux", reason="limits of Linux")
def test_a_limited_address_space_is_seen():
    _, memory, source = asked("sh", "-c", 'ulimit -v 2000000; exec "$@"', "sh")
    assert source == "limit 2.05 GB of the address space, ulimit -v"
    assert 1e9 < memory < 2.0e9


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("taskset") is None, reason="no taskset")
def test_the_plan_of_one_core_has_one_worker():
    words = [
        "taskset",
        "-c",
        str(min(os.sched_getaffinity(0))),
        sys.executable,
        "-m",
        "roughsim",
        "plan",
        "demo",
    ]
    said = subprocess.run(
        words, capture_output=True, text=True, check=True, env={**os.environ, "COLUMNS": "200"}
    )
    line = next(line for line in said.stdout.splitlines() if line.startswith("workers"))
    assert line.split()[1] == "1"
