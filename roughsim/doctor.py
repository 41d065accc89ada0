"""What this installation is, what it lacks, and whether it computes: versions, threads, memory, runs, two exact cases.

Nothing here is needed by a run. Whatever is broken is a finding, not an error: `examine` always returns.
"""

from __future__ import annotations

import os
import platform
import re
import time
from collections.abc import Callable, Iterator
from importlib import metadata
from math import pi, sqrt
from pathlib import Path
from typing import Any

from roughsim import __version__

_DEVELOPERS = {"test", "dev", "docs", "peers"}  # extras that no user misses
_REPLACEABLE = {"pyfftw"}  # without it scipy.fft takes over, slower
_POINTS = 64


def examine(folder: Path) -> dict[str, Any]:
    """Look at the installation, the machine, and the runs below a folder.

    Parameters
    ----------
    folder : Path
        Where runs are looked for, one and two levels down.

    Returns
    -------
    dict
        JSON values: ``roughsim``, ``python``, ``system``, ``packages`` (name → {version, needed, sound}), ``fft``,
        ``cores``, ``threads`` (library → count), ``memory_bytes``, ``free_bytes`` (of the folder's disk), ``claims``
        (runs that processes work on), ``extras`` (name → {missing, install}), ``checks``, and ``sound``: whether a run
        can be trusted to compute.
    """
    packages = {name: _package(name, least) for name, least, extra in _requirements() if not extra}
    checks = [_checked(name, check) for name, check in _CHECKS.items()]
    return {
        "roughsim": __version__,
        "place": str(Path(__file__).parent),
        "python": platform.python_version(),
        "system": platform.platform(),
        "packages": packages,
        "fft": _told(_backend),
        "cores": _cores(),
        "threads": _told(_threads),
        "memory_bytes": _told(_memory),
        "free_bytes": _told(lambda: _free(folder)),
        "claims": list(_claims(folder)),
        "extras": _extras(),
        "checks": checks,
        "sound": all(check["sound"] for check in checks)
        and all(found["sound"] for name, found in packages.items() if name not in _REPLACEABLE),
    }


def lines(found: dict[str, Any]) -> list[str]:
    """Return what `examine` found, for people."""
    threads = ", ".join(f"{name} {count}" for name, count in (found["threads"] or {}).items())
    told = [
        f"roughsim {found['roughsim']} in {found['place']}",
        f"Python {found['python']} on {found['system']}",
        "packages: " + ", ".join(f"{name} {one['version']}" for name, one in found["packages"].items()),
        f"transforms: {found['fft']}",
        f"cores: {found['cores']}; threads of libraries: {threads or 'unknown'}",
        f"memory: {_gigabytes(found['memory_bytes'])}; free disk here: {_gigabytes(found['free_bytes'])}",
    ]
    told += [f"{name} is wanted as {one['needed']}: {one['install']}" for name, one in _unsound(found)]
    told += [f"run: {one['folder']} {one['says']}" for one in found["claims"]] or ["runs at work: none below here"]
    for name, extra in found["extras"].items():
        lacks = f"lacks {', '.join(extra['missing'])}: {extra['install']}" if extra["missing"] else "complete"
        told.append(f"extra {name}: {lacks}")
    told += [f"check {one['name']}: {one['says']}, {one['seconds']:.2g} s" for one in found["checks"]]
    return [*told, "all is well" if found["sound"] else "something is wrong: see the lines above"]


def _unsound(found: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    return [(name, one) for name, one in found["packages"].items() if not one["sound"]]


def _gigabytes(size: float | None) -> str:
    return "unknown" if size is None else f"{size / 1e9:.1f} GB"


def _told(ask: Callable[[], Any]) -> Any:
    """The answer, or None where there is none to be had."""
    try:
        return ask()
    except Exception:  # a broken package fails in its own way, and this is where one comes to look
        return None


def _requirements() -> Iterator[tuple[str, str, str]]:
    """Name, least version and extra of each package that the installed roughsim declares."""
    for text in _told(lambda: metadata.requires("roughsim")) or ():
        name = re.match(r"[A-Za-z0-9._-]+", text)
        least, extra = re.search(r">=\s*([0-9.]+)", text), re.search(r"extra\s*==\s*['\"]([^'\"]+)", text)
        if name is not None:
            yield name[0], least[1] if least else "", extra[1] if extra else ""


def _package(name: str, least: str) -> dict[str, Any]:
    try:
        version = metadata.version(name)
    except metadata.PackageNotFoundError:
        version = "missing"
    sound = version != "missing" and (not least or _numbers(version) >= _numbers(least))
    needed = f"{name}>={least}" if least else name
    return {"version": version, "needed": needed, "sound": sound, "install": f"pip install '{needed}'"}


def _numbers(version: str) -> list[int]:
    return [int(part) for part in re.findall(r"\d+", version)[:3]]


def _extras() -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for name, least, extra in _requirements():
        if not extra or extra in _DEVELOPERS:
            continue
        entry = found.setdefault(extra, {"missing": [], "install": ""})
        package = _package(name, least)
        if not package["sound"]:
            entry["missing"].append(package["needed"])
            entry["install"] = "pip install " + " ".join(f"'{one}'" for one in entry["missing"])
    return found


def _backend() -> str:
    from roughsim.fourier import backend

    return backend()


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _threads() -> dict[str, int]:
    import scipy.linalg  # noqa: F401  (its BLAS is one of those asked)
    from threadpoolctl import threadpool_info

    return {str(pool["internal_api"]): int(pool["num_threads"]) for pool in threadpool_info()}


def _memory() -> float | None:
    from roughsim.untrusted import machine_memory

    memory = machine_memory()
    return memory if memory < float("inf") else None


def _free(folder: Path) -> int:
    import shutil

    return shutil.disk_usage(folder).free


def _claims(folder: Path) -> Iterator[dict[str, Any]]:
    from roughsim.store.claims import writer

    for path in sorted({*folder.glob("claims"), *folder.glob("*/claims"), *folder.glob("*/*/claims")}):
        if not (path.parent / "run.json").exists():
            continue
        owner = writer(path.parent)
        says = f"is being computed by {owner}" if owner else "was left by processes that are gone; the next run goes on"
        yield {"folder": str(path.parent), "writer": owner, "says": says}


def _contact_error() -> tuple[str, float, float]:
    """Peak pressure of a pressed wave: p_max = 2 √(σ₀ p*), p* = π E* h/λ (Westergaard 1939), in partial contact."""
    import numpy as np

    import roughsim as rs

    grid = rs.Grid((_POINTS, _POINTS), (1e-3, 1e-3))
    heights = 1e-6 * np.cos(2 * pi * np.arange(_POINTS) / _POINTS)[:, None] * np.ones(_POINTS)
    full = pi * 1e11 * 1e-6 / 1e-3
    contact = rs.solve_contact(heights, grid, rs.Solid(1e11), nominal_pressure=0.25 * full, tolerance=1e-8)
    return "peak pressure of a pressed wave", float(contact.pressure.max()) / (2 * sqrt(0.25) * full) - 1, 0.005


def _heat_error() -> tuple[str, float, float]:
    """A resting cosine source of heat on a half-space: T = q̇/(κ q)."""
    import numpy as np

    import roughsim as rs

    grid = rs.Grid((_POINTS, _POINTS), (1e-3, 1e-3))
    flux = 1e9 * np.cos(2 * pi * 3 * np.arange(_POINTS) / _POINTS)[:, None] * np.ones(_POINTS)
    heat = {"speed": 0.0, "conductivity": 30.0, "diffusivity": 7.6e-6}
    temperature = rs.sliding_temperature(flux, grid, **heat)
    return "temperature of a resting wave", float(temperature.max()) / (1e9 / (30.0 * 2 * pi * 3 / 1e-3)) - 1, 1e-9


_CHECKS: dict[str, Callable[[], tuple[str, float, float]]] = {"contact": _contact_error, "heat": _heat_error}


def _checked(name: str, check: Callable[[], tuple[str, float, float]]) -> dict[str, Any]:
    start = time.perf_counter()
    try:
        what, error, limit = check()
    except Exception as failure:  # whatever goes wrong is what is to be told
        says = f"failed, {type(failure).__name__}: {' '.join(str(failure).split())}"
        return {"name": name, "error": None, "sound": False, "says": says, "seconds": time.perf_counter() - start}
    sound = abs(error) <= limit
    says = f"{'right' if sound else 'WRONG'}: {what} {_POINTS}², {error:+.1e} off the exact value (limit {limit:g})"
    return {"name": name, "error": error, "sound": sound, "says": says, "seconds": time.perf_counter() - start}
