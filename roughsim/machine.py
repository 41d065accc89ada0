"""Memory and cores of this process: the least by machine, control groups and own limits.

Batch systems and containers limit a job through control groups (cgroups) of Linux, version 1 or 2, or through the
limits that a process inherits (`ulimit`). A job that takes more memory is killed without a word.
"""

import os
from collections.abc import Iterator
from contextlib import suppress
from math import inf
from pathlib import Path
from typing import NamedTuple

from roughsim.errors import ResolutionError

SHARE = 0.8  # of the memory, for all members that are computed at the same time
# peak memory of a member, measured on 2048² points: 85 to 92; in a study, with the member before it, 118
BYTES_PER_POINT = 120.0
PROCESS = 0.25e9  # bytes that a worker takes beside its member: Python and its libraries, measured
SMALL = 1e7  # bytes that always fit: to ask for the memory takes a millisecond
_ROOT = Path("/")
# names of the files of a control group, by version: limits of the memory, its use, and in memory.stat the part of it
# that holds files and is given back on demand
_MEMORY_FILES = {
    1: (("memory.limit_in_bytes",), "memory.usage_in_bytes", "total_inactive_file"),
    2: (("memory.max", "memory.high"), "memory.current", "inactive_file"),
}


class Available(NamedTuple):
    """An amount of memory, bytes, or of cores, that is available, and the source of the limit."""

    amount: float
    source: str


def available_memory(root: Path = _ROOT) -> Available:
    """Return the memory available to this process and its children together.

    A limit of the address space holds for each process; it is applied to all together, as batch systems intend it. inf
    if the system gives no number. `root` is the folder with proc and sys.
    """
    limits = [_machine_memory(root), *_group_memory(root), *_own_limits(root)]
    return min(limits, key=lambda limit: limit.amount)


def usable_cores(root: Path = _ROOT) -> Available:
    """Return the number of cores that this process may use, at least 1; `root` is the folder with proc and sys."""
    limits = [allowed_cores(), *_group_cores(root)]
    return min(limits, key=lambda limit: limit.amount)


def workers_that_fit(wanted: int, member: float, why: str, available: Available) -> int:
    """Return the number of processes, 1 to `wanted`, whose members, of `member` bytes each, fit into memory together.

    ResolutionError if one member does not fit; `why` is the part that needs the memory.
    """
    room = SHARE * available.amount
    if member > room:
        raise ResolutionError(
            f"memory = {member / 1e9:.3g} GB ({why}) exceeds {100 * SHARE:.0f} % of the {in_words(available)}; lower "
            "the levels' shape, or ask for more memory"
        )
    most = wanted if room == inf else int(room // (member + PROCESS))
    return max(min(wanted, most), 1)  # one needs no process of its own


def in_words(memory: Available) -> str:
    """Return an amount of memory with the source of its limit."""
    return f"{memory.amount / 1e9:.3g} GB that are available ({memory.source})"


def exceeds(needed: float, share: float) -> bool:
    """Whether so many bytes are more than a share of the available memory."""
    return needed > SMALL and needed > share * available_memory().amount


def _machine_memory(root: Path) -> Available:
    """Return the free memory of the machine; without Linux its total memory; inf if unknown."""
    for line in _lines_of(root / "proc/meminfo"):
        if line.startswith("MemAvailable:"):
            return Available(1024.0 * float(line.split()[1]), "free on this machine")
    with suppress(ValueError, OSError, AttributeError):
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
        return Available(float(memory), "the memory of this machine")
    return Available(inf, "unknown")


def _group_memory(root: Path) -> Iterator[Available]:
    """Yield the memory left by each control group of this process, bytes: its limit less memory that stays in use."""
    for folder, version in _control_groups("memory", root):
        limits, use, files = _MEMORY_FILES[version]
        words = [line.split() for line in _lines_of(folder / "memory.stat")]
        freed = sum(float(line[1]) for line in words if line[:1] == [files])
        used = max(_number_in(folder / use, 0.0) - freed, 0.0)
        for limit in (_number_in(folder / name) for name in limits):
            if limit < inf:
                source = f"limit {limit / 1e9:.3g} GB of the control group"
                yield Available(max(limit - used, 0.0), source)


def _own_limits(root: Path) -> Iterator[Available]:
    """Yield the memory left by the limits of this process (`ulimit -v` and `-d`), bytes."""
    try:
        import resource
    except ImportError:  # Windows
        return
    pages = [float(word) for line in _lines_of(root / "proc/self/statm") for word in line.split()]
    names = ("RLIMIT_AS", 0, "address space, ulimit -v"), ("RLIMIT_DATA", 5, "data, ulimit -d")
    for name, place, words in names:
        limit = resource.getrlimit(getattr(resource, name))[0]
        if limit != resource.RLIM_INFINITY:
            used = pages[place] * resource.getpagesize() if pages else 0.0
            yield Available(max(limit - used, 0.0), f"limit {limit / 1e9:.3g} GB of the {words}")


def allowed_cores() -> Available:
    """Return the number of cores on which this process may run."""
    if hasattr(os, "process_cpu_count"):  # from Python 3.13 on; a user may set it, too
        return Available(os.process_cpu_count() or 1, "allowed to this process")
    if hasattr(os, "sched_getaffinity"):
        return Available(len(os.sched_getaffinity(0)), "allowed to this process")
    return Available(os.cpu_count() or 1, "of this machine")


def _group_cores(root: Path) -> Iterator[Available]:
    """Yield the CPU quota of each control group of this process, in whole cores, at least 1."""
    for folder, version in _control_groups("cpu", root):
        if version == 2:
            words = [word for line in _lines_of(folder / "cpu.max") for word in line.split()]
            quota, period = map(_as_number, words) if len(words) == 2 else (inf, 1.0)
        else:
            names = "cpu.cfs_quota_us", "cpu.cfs_period_us"
            quota, period = (_number_in(folder / name) for name in names)
        if 0.0 < quota < inf and 0.0 < period < inf:  # version 1 has the quota −1 for none
            source = f"limit {quota / period:.3g} cores of the control group"
            yield Available(max(int(quota / period), 1), source)


def _control_groups(controller: str, root: Path) -> Iterator[tuple[Path, int]]:
    """Yield the folder and version of the control group of this process, and of each one above it.

    /proc/self/cgroup has the path of the group in its hierarchy, /proc/self/mountinfo the mount point of the hierarchy
    and the mounted part: in a container the group may lie above that part, or have the path "/".
    """
    paths: dict[tuple[int, str], str] = {}
    for line in _lines_of(root / "proc/self/cgroup"):
        number, controllers, path = line.split(":", 2)
        for name in controllers.split(",") if number != "0" else [""]:
            paths[2 if number == "0" else 1, name] = path
    for line in _lines_of(root / "proc/self/mountinfo"):
        before, _, after = line.partition(" - ")
        (top, mount), (kind, *_, options) = before.split()[3:5], after.split()
        version, hierarchy = (2, "") if kind == "cgroup2" else (1, controller)
        mounted = kind == "cgroup2" or (kind == "cgroup" and controller in options.split(","))
        if not mounted or (version, hierarchy) not in paths:
            continue
        path, folder = paths[version, hierarchy], root / mount.lstrip("/")
        yield folder, version
        inside = Path(path).relative_to(top).parts if Path(path).is_relative_to(top) else ()
        for part in inside if ".." not in inside else ():
            folder = folder / part
            yield folder, version


def _number_in(path: Path, default: float = inf) -> float:
    """Return the number in the first line of a file; the default if there is no file or no number, as with "max"."""
    return next((_as_number(line, default) for line in _lines_of(path)), default)


def _as_number(text: str, default: float = inf) -> float:
    """Return a text as a number, or the default."""
    try:
        return float(text)
    except ValueError:
        return default


def _lines_of(path: Path) -> list[str]:
    """Return the lines of a small file of the system; none if it cannot be read."""
    try:
        return path.read_text(errors="replace").splitlines()
    except OSError:
        return []
