"""`roughsim doctor`: versions, missing packages, threads, memory, unfinished runs, and two cases with exact answers.

No run needs this module. A broken part is reported, not raised: `examine` always returns.
"""

import platform
import re
import shutil
import time
from collections.abc import Callable, Iterator
from importlib import import_module, metadata
from math import pi
from pathlib import Path
from typing import Any

import roughsim as rs

# extras for developers: not reported when they are missing
_DEVELOPERS = {"test", "dev", "docs", "peers"}
_REPLACEABLE = {"pyfftw"}  # without it scipy.fft computes the transforms, slower
POINTS = 64  # per side of the exact cases


def examine(folder: Path) -> dict[str, Any]:
    """Look at the installation, the machine, and the runs below a folder.

    Returns JSON values: ``roughsim``, ``python``, ``system``, ``packages`` (name → {version, needed, sound}), ``fft``,
    ``cores``, ``memory_bytes`` (both for this process), ``cores_limit``, ``memory_limit`` (source of the limit),
    ``threads`` (library → count), ``free_bytes`` (of the folder's disk), ``claims`` (runs,
    one and two levels below, that processes work on), ``extras`` (name → {missing, install}), ``checks``, and
    ``sound``: whether a run can be trusted to compute.
    """
    packages: dict[str, dict[str, Any]] = {}
    extras: dict[str, dict[str, Any]] = {}
    for extra, name, package in _required_packages():
        if not extra:
            packages[name] = package
        elif extra not in _DEVELOPERS:
            missing = extras.setdefault(extra, {"missing": [], "install": ""})["missing"]
            if not package["sound"]:
                missing.append(package["needed"])
                quoted = [f"'{needed}'" for needed in missing]
                extras[extra]["install"] = f"pip install {' '.join(quoted)}"
    checks = [checked(name, check) for name, check in CHECKS.items()]
    machine = import_module("roughsim.machine")
    cores, memory = machine.usable_cores(), machine.available_memory()
    needed = [package["sound"] for name, package in packages.items() if name not in _REPLACEABLE]
    return {
        "roughsim": rs.__version__,
        "place": str(Path(rs.__file__).parent),
        "python": platform.python_version(),
        "system": platform.platform(),
        "packages": packages,
        "fft": _none_if_broken(lambda: import_module("roughsim.fourier").backend()),
        "cores": int(cores.amount),
        "cores_limit": cores.source,
        "threads": _none_if_broken(_library_threads),
        # inf if the system gives no number: int(inf) raises, and the result is None
        "memory_bytes": _none_if_broken(lambda: int(memory.amount)),
        "memory_limit": memory.source,
        "free_bytes": _none_if_broken(lambda: shutil.disk_usage(folder).free),
        "claims": list(_claims_below(folder)),
        "extras": extras,
        "checks": checks,
        "sound": all(check["sound"] for check in checks) and all(needed),
    }


def lines(report: dict[str, Any]) -> list[str]:
    """Return the report of `examine` as lines for people."""
    threads = ", ".join(f"{name} {count}" for name, count in (report["threads"] or {}).items())
    memory = _gigabytes(report["memory_bytes"])
    disk = _gigabytes(report["free_bytes"])
    versions = [f"{name} {package['version']}" for name, package in report["packages"].items()]
    result = [
        f"roughsim {report['roughsim']} in {report['place']}",
        f"Python {report['python']} on {report['system']}",
        f"packages: {', '.join(versions)}",
        f"transforms: {report['fft']}",
        f"cores: {report['cores']} ({report['cores_limit']}); threads of libraries: {threads or 'unknown'}",
        f"memory: {memory} ({report['memory_limit']}); free disk here: {disk}",
    ]
    for name, package in report["packages"].items():
        if not package["sound"]:
            result.append(f"{name} is needed as {package['needed']}: {package['install']}")
    runs = [f"run: {claim['folder']} {claim['says']}" for claim in report["claims"]]
    result += runs or ["runs at work: none below here"]
    for name, extra in report["extras"].items():
        lacking = f"lacks {', '.join(extra['missing'])}: {extra['install']}"
        result.append(f"extra {name}: {lacking if extra['missing'] else 'complete'}")
    for check in report["checks"]:
        result.append(f"check {check['name']}: {check['says']}, {check['seconds']:.2g} s")
    result.append("all is well" if report["sound"] else "something is wrong: see the lines above")
    return result


def _gigabytes(amount: float | None) -> str:
    """Return a number of bytes in GB."""
    return "unknown" if amount is None else f"{amount / 1e9:.1f} GB"


def _none_if_broken(ask: Callable[[], Any]) -> Any:
    """Return ``ask()``, or None if it fails: a broken package may raise anything, and the report must still come."""
    try:
        return ask()
    except Exception:
        return None


def _required_packages() -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield extra (or ""), name and state of each package that the installed roughsim requires."""
    for text in _none_if_broken(lambda: metadata.requires("roughsim")) or ():
        name, least, extra = (
            match[1] if (match := re.search(pattern, text)) else ""
            for pattern in (
                r"^([A-Za-z0-9._-]+)",
                r">=\s*([0-9.]+)",
                r"extra\s*==\s*['\"]([^'\"]+)",
            )
        )
        try:
            version = metadata.version(name)
        except metadata.PackageNotFoundError:
            version = "missing"
        present, enough = ([*map(int, re.findall(r"\d+", v)[:3])] for v in (version, least))
        needed = f"{name}>={least}" if least else name
        yield (
            extra,
            name,
            {
                "version": version,
                "needed": needed,
                "sound": version != "missing" and present >= enough,
                "install": f"pip install '{needed}'",
            },
        )


def _library_threads() -> dict[str, int]:
    """Return the number of threads of each library that has any."""
    import scipy.linalg  # noqa: F401  (loads the BLAS of scipy, so that it is counted)
    from threadpoolctl import threadpool_info

    return {str(pool["internal_api"]): int(pool["num_threads"]) for pool in threadpool_info()}


def _claims_below(folder: Path) -> Iterator[dict[str, Any]]:
    """Yield the runs and studies, up to two folders down, that processes work on or left unfinished."""
    from roughsim.store.claims import writer

    patterns = "claims", "*/claims", "*/*/claims"
    for path in sorted({path for pattern in patterns for path in folder.glob(pattern)}):
        if any((path.parent / name).exists() for name in ("run.json", "study.json")):
            owner = writer(path.parent)
            gone = "was left unfinished by processes that have ended; run the scene again to go on"
            says = f"is being computed by {owner}" if owner else gone
            yield {"folder": str(path.parent), "writer": owner, "says": says}


def _contact_error() -> tuple[str, float, float]:
    """Peak pressure of a pressed wave: p_max = 2 √(σ₀ p*), p* = π E* h/λ (Westergaard 1939), in partial contact."""
    import numpy as np

    grid = rs.Grid((POINTS, POINTS), (1e-3, 1e-3))
    heights = 1e-6 * np.cos(2 * pi * np.arange(POINTS) / POINTS)[:, None] * np.ones(POINTS)
    full = pi * 1e11 * 1e-6 / 1e-3  # p*: at a quarter of it p_max = 2 √(p*/4 p*) = p*
    contact = rs.solve_contact(
        heights, grid, rs.Solid(1e11), nominal_pressure=0.25 * full, tolerance=1e-8
    )
    return "peak pressure of a pressed wave", float(contact.pressure.max()) / full - 1, 0.005


def _heat_error() -> tuple[str, float, float]:
    """A resting cosine source of heat on a half-space: T = q̇/(κ q)."""
    import numpy as np

    grid = rs.Grid((POINTS, POINTS), (1e-3, 1e-3))
    flux = 1e9 * np.cos(2 * pi * 3 * np.arange(POINTS) / POINTS)[:, None] * np.ones(POINTS)
    heat: dict[str, Any] = {"speed": 0.0, "conductivity": 30.0, "diffusivity": 7.6e-6}
    hottest = float(rs.sliding_temperature(flux, grid, **heat).max())
    exact = 1e9 / (30.0 * 2 * pi * 3 / 1e-3)
    return "temperature of a resting wave", hottest / exact - 1, 1e-9


# each returns the quantity, its relative error, and the largest error that is right
CHECKS: dict[str, Callable[[], tuple[str, float, float]]] = {
    "contact": _contact_error,
    "heat": _heat_error,
}


def checked(name: str, check: Callable[[], tuple[str, float, float]]) -> dict[str, Any]:
    """Return the verdict of one exact case as JSON values."""
    start, error = time.perf_counter(), None
    try:
        what, error, limit = check()
        sound = abs(error) <= limit
        verdict = f"{'right' if sound else 'WRONG'}: {what} {POINTS}²"
        says = f"{verdict}, {error:+.1e} off the exact value (limit {limit:g})"
    except Exception as failure:  # any failure is a finding
        sound, says = False, f"failed, {type(failure).__name__}: {' '.join(str(failure).split())}"
    seconds = time.perf_counter() - start
    return {"name": name, "error": error, "sound": sound, "says": says, "seconds": seconds}
