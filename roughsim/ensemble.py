"""Realizations, alone and many: synthesis, contact and moments of each member, in this process or several.

A member is named by (level, index) and has one random stream, SeedSequence(seed, spawn_key=(stream, index)); all levels
of a run share the stream of the finest, so they see the same modes. Who computes a member, and when, changes no bit.
"""

from __future__ import annotations

import multiprocessing
import platform
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughsim import analytic, fourier
from roughsim.contact import Contact, Solid, solve_contact
from roughsim.errors import ConvergenceError, RecordError
from roughsim.estimate import UNITS
from roughsim.grid import Grid
from roughsim.observables import Observables, Sliding, measure
from roughsim.plan import Numerics, plan
from roughsim.record import (
    Member,
    Run,
    describe,
    member_path,
    open_run,
    read_description,
    read_member,
    write_member,
    writing,
)
from roughsim.record.files import FORMAT
from roughsim.spectrum import Spectrum, TruncatedSpectrum
from roughsim.surface import synthesize

if TYPE_CHECKING:
    from roughsim.scene import Scene

RETRIES = 3  # how often a pool whose worker died is started anew
_AT_REST = 1e-150  # a speed of zero is measured at this one, m/s: the limits D_flash and s need a ratio of moments


@dataclass(frozen=True, slots=True, eq=False)
class Realization:
    """One member: a surface, its contact, and what was measured of it (all heat in the moving body).

    Attributes
    ----------
    level, index, seed : int
        Which member it is.
    grid : Grid
        Its cell.
    heights : ndarray
        Composite heights, m.
    contact : Contact
        The solved contact.
    observables : Observables
        Moments at the scene's speeds, averaged over directions.
    seconds : dict of str to float
        Time spent in each stage.
    """

    level: int
    index: int
    seed: int
    grid: Grid
    heights: NDArray[np.float64]
    contact: Contact
    observables: Observables
    seconds: dict[str, float]


def realize(scene: Scene, numerics: Numerics, *, seed: int, level: int = 0, index: int = 0) -> Realization:
    """Compute one member of an ensemble.

    Parameters
    ----------
    scene : Scene
        What is computed.
    numerics : Numerics
        How well; its `levels[level]` says which contact, grid and cut-off.
    seed : int
        Of the ensemble, ≥ 0.
    level, index : int
        Which member.

    Returns
    -------
    Realization
        The fields and what was measured.

    Raises
    ------
    ConvergenceError
        If the contact does not reach the tolerance.
    ValueError
        If `seed`, `level` or `index` do not exist.
    """
    for name, value, limit in (
        ("seed", seed, np.inf),
        ("level", level, len(numerics.levels)),
        ("index", index, np.inf),
    ):
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 <= value < limit:
            raise ValueError(f"{name} = {value!r} must be a whole number from 0 to below {limit:g}")
    grid = numerics.grid(level)
    stream = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(numerics.stream, index)))
    marks = [time.perf_counter()]
    heights = synthesize(level_spectrum(scene, numerics, level), grid, stream)
    marks.append(time.perf_counter())
    contact = solve_contact(
        heights,
        grid,
        _solid(scene, numerics.levels[level].column),
        nominal_pressure=scene.sliding.nominal_pressure,
        tolerance=numerics.tolerance,
        precision=numerics.precision,
    )
    marks.append(time.perf_counter())
    observables = measure(contact, grid, _sliding(scene))
    marks.append(time.perf_counter())
    seconds = dict(zip(("surface", "contact", "observables"), np.diff(marks).tolist(), strict=True))
    return Realization(level, index, seed, grid, heights, contact, observables, seconds)


@lru_cache(maxsize=16)
def level_spectrum(scene: Scene, numerics: Numerics, level: int) -> Spectrum:
    """Return the spectrum that a level's surfaces are drawn from: C, or C_sm for "smoothed", cut at its q_max."""
    wanted = numerics.levels[level]
    if wanted.column == "smoothed":
        return TruncatedSpectrum(analytic.smoothed_spectrum(scene), wanted.q_max)
    return scene.spectrum.truncated(q_max=wanted.q_max)


def _solid(scene: Scene, column: str) -> Solid:
    if column == "capped":
        return Solid(scene.effective_modulus, scene.penetration_hardness)
    return Solid(scene.effective_modulus)


def _sliding(scene: Scene) -> Sliding:
    return Sliding(
        speeds=[speed or _AT_REST for speed in scene.speeds],
        friction_coefficient=scene.sliding.friction_coefficient,
        conductivity=scene.body.conductivity,
        diffusivity=scene.diffusivity,
    )


def run(
    scene: Scene,
    folder: str | Path,
    *,
    numerics: Numerics | None = None,
    seed: int | None = None,
    until: dict[str, float] | None = None,
    max_realizations: int | None = None,
    workers: int = 1,
    executor: Executor | None = None,
    observer: Callable[[Run], None] | None = None,
) -> Run:
    """Compute an ensemble into a folder, or go on with the one that is there.

    Parameters
    ----------
    scene : Scene
        What is computed.
    folder : str or Path
        The run folder; made if it does not exist. The same scene, numerics and seed resume it.
    numerics : Numerics, optional
        From `plan` if left out.
    seed : int, optional
        The scene's if left out.
    until : dict of str to float, optional
        Relative 95 % half-width of each named observable at which to stop, at the worst speed; the scene's if left out.
    max_realizations : int, optional
        Where to stop in any case; the scene's if left out.
    workers : int, optional
        Processes; 1 computes in this one. A script that asks for more needs ``if __name__ == "__main__":``.
    executor : concurrent.futures.Executor, optional
        Used in place of own processes.
    observer : callable, optional
        Called with the run after each member has been stored.

    Returns
    -------
    Run
        The run as it stands at the end.

    Raises
    ------
    RecordError
        If the folder holds another scene, naming the first key that differs, or another process writes to it.
    OSError
        If the disk refuses; what was stored stays.
    TypeError, ValueError
        Naming the argument, before any work.
    """
    if isinstance(workers, bool) or int(workers) != workers or workers < 1:
        raise ValueError(f"workers = {workers!r} must be a whole number ≥ 1")
    goals = _checked_goals(dict(scene.ensemble.until) if until is None else until)
    scene = replace(
        scene,
        ensemble=replace(
            scene.ensemble,
            seed=scene.ensemble.seed if seed is None else seed,
            max_realizations=scene.ensemble.max_realizations if max_realizations is None else max_realizations,
            until=tuple(goals.items()),
        ),
    )
    numerics = plan(scene) if numerics is None else numerics
    place = Path(folder)
    _prepare(place, scene, numerics)
    with writing(place):
        describe(place, _description(scene, numerics), scene)
        result = open_run(place)
        tasks = _Tasks(scene, numerics, place, result)
        with _pool(workers, executor, numerics.threads) as pool:
            tasks.complete(pool, workers, observer)
    return result


def _checked_goals(until: dict[str, float]) -> dict[str, float]:
    for name, goal in until.items():
        if name not in UNITS:
            raise ValueError(f"until = {name!r} is no observable; choose among {', '.join(UNITS)}")
        if not 0.0 < goal < 1.0:
            raise ValueError(f"until: {name} = {goal!r} must lie between 0 and 1; write 0.01 for 1 %")
    return until


def _prepare(place: Path, scene: Scene, numerics: Numerics) -> None:
    """Make the folder, or see that it holds this very scene."""
    if place.exists() and not place.is_dir():
        raise RecordError(f"{place} is a file; name a folder for the run")
    if not (place / "run.json").exists():
        if place.exists() and any(place.iterdir()):
            raise RecordError(f"{place} holds other files; name a new folder for the run")
        place.mkdir(parents=True, exist_ok=True)
        return
    there, wanted = read_description(place), _description(scene, numerics)
    for part in ("scene", "numerics"):
        for key in dict.fromkeys((*there[part], *wanted[part])):
            old, new = there[part].get(key), wanted[part].get(key)
            if old != new and key != "keep_fields":
                raise RecordError(
                    f"{place} holds another scene: {key} is {old} there and {new} here; name another folder, or give "
                    f"the scene as it was"
                )


def _description(scene: Scene, numerics: Numerics) -> dict[str, Any]:
    """What run.json says: all that the run is, as JSON values."""
    return {
        "format_version": FORMAT,
        "scene": scene.identity(),
        "numerics": numerics.to_dict(),
        "seed": scene.ensemble.seed,
        "until": dict(scene.ensemble.until),
        "max_realizations": scene.ensemble.max_realizations,
        "heat_partition": analytic.heat_partition(scene).tolist(),
        "versions": versions(),
    }


def versions() -> dict[str, str]:
    """Return the versions that the bits of a result may depend on."""
    found = {"python": platform.python_version(), "fft": fourier.backend()}
    for package in ("roughsim", "numpy", "scipy", "numba", "h5py"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "unknown"
    return found


@contextmanager
def _pool(workers: int, executor: Executor | None, threads: int) -> Iterator[Callable[[], Executor | None]]:
    """Yield what makes a pool, and shut down the last one made; a given executor is left to its owner."""
    made: list[Executor] = []

    def make() -> Executor | None:
        if executor is not None or workers == 1:
            return executor
        context = multiprocessing.get_context("spawn")  # fork after threaded transforms hangs
        made.append(ProcessPoolExecutor(workers, mp_context=context, initializer=_begin_worker, initargs=(threads,)))
        return made[-1]

    try:
        yield make
    finally:
        for pool in made:
            pool.shutdown(wait=True, cancel_futures=True)


def _begin_worker(threads: int) -> None:
    """Keep to the threads that the plan allows, also in linear algebra; leave interrupts to the main process."""
    import signal

    from threadpoolctl import threadpool_limits

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threadpool_limits(threads)


class _Tasks:
    """The members still to do, in order, and the run that they make up."""

    def __init__(self, scene: Scene, numerics: Numerics, place: Path, result: Run):
        self.scene, self.numerics, self.place, self.result = scene, numerics, place, result

    def _to_do(self) -> Iterator[tuple[int, int]]:
        """Yield (level, index) of what is not stored yet, index by index, the largest grid first."""
        levels = sorted(range(len(self.numerics.levels)), key=lambda i: -self.numerics.grid(i).points)
        for index in range(self.scene.ensemble.max_realizations):
            yield from ((level, index) for level in levels if not self._stored(level, index))

    def _stored(self, level: int, index: int) -> bool:
        """Whether a sound or failed member is there; a damaged file is done again."""
        path = member_path(self.place, level, index)
        if not path.exists():
            return False
        try:
            read_member(path)
        except RecordError as error:
            warnings.warn(f"{error}; doing it again", RuntimeWarning, stacklevel=2)
            path.unlink()
            return False
        return True

    def complete(
        self, make: Callable[[], Executor | None], workers: int, observer: Callable[[Run], None] | None
    ) -> None:
        """Work through the tasks until the targets are met or there are none left."""
        for attempt in range(RETRIES + 1):
            pool = make()
            try:
                if pool is None:
                    self._alone(observer)
                else:
                    self._shared(pool, 2 * workers, observer)
            except BrokenExecutor as error:
                if attempt == RETRIES:
                    raise RuntimeError(
                        f"workers died {RETRIES + 1} times, last: {error}; see memory and disk"
                    ) from error
                continue
            return

    def _alone(self, observer: Callable[[Run], None] | None) -> None:
        for level, index in self._to_do():
            if self.result.target_met:
                return
            store_member(self.scene, self.numerics, level, index, self.place)
            self._note(observer)

    def _shared(self, pool: Executor, ahead: int, observer: Callable[[Run], None] | None) -> None:
        to_do = self._to_do()
        pending: set[Future[None]] = set()
        try:
            while not self.result.target_met:
                while len(pending) < ahead and (task := next(to_do, None)) is not None:
                    pending.add(pool.submit(store_member, self.scene, self.numerics, *task, self.place))
                if not pending:
                    return
                done, pending = wait(pending, return_when=FIRST_COMPLETED)
                for future in done:
                    future.result()
                self._note(observer)
        finally:
            for future in pending:
                future.cancel()

    def _note(self, observer: Callable[[Run], None] | None) -> None:
        self.result.refresh()
        if observer is not None:
            observer(self.result)


def store_member(scene: Scene, numerics: Numerics, level: int, index: int, place: Path) -> None:
    """Compute one member and write its file; a solve that does not converge is stored as a failure."""
    fourier.set_threads(numerics.threads)
    seed = scene.ensemble.seed
    try:
        with warnings.catch_warnings():
            # the plan says what a cell leaves out of the spectrum; each member need not repeat it
            warnings.filterwarnings("ignore", message="q_min = ", category=RuntimeWarning)
            one = realize(scene, numerics, seed=seed, level=level, index=index)
    except ConvergenceError as error:
        provenance = _provenance(scene, numerics, error.residual, error.iterations, {})
        write_member(place, Member(level, index, failure=str(error), lengths=numerics.lengths, provenance=provenance))
        return
    write_member(place, _member(scene, numerics, one))


def _member(scene: Scene, numerics: Numerics, one: Realization) -> Member:
    seen, contact = one.observables, one.contact
    numbers = {
        "flash_temperature": seen.flash_temperature,
        "flash_gradient": seen.flash_gradient,
        "flash_laplacian": seen.flash_laplacian,
        "resting_flash_temperature": seen.resting_flash_temperature,
        "contact_fraction": np.array([contact.contact_fraction]),
        "plastic_fraction": np.array([contact.plastic_fraction]),
        "pressure_variance": np.array([seen.pressure_variance]),
    }
    kept = one.index < numerics.keep_fields
    fields = {"heights": one.heights, "pressure": contact.pressure} if kept else {}
    return Member(
        one.level,
        one.index,
        numbers=numbers,
        wavenumber=seen.stress_spectrum.wavenumber,
        spectrum=seen.stress_spectrum.variance,
        fields={name: values.astype(np.float32) for name, values in fields.items()},
        lengths=numerics.lengths,
        provenance=_provenance(scene, numerics, contact.residual, contact.iterations, one.seconds),
    )


def _provenance(
    scene: Scene, numerics: Numerics, residual: float, iterations: int, seconds: dict[str, float]
) -> dict[str, Any]:
    return {
        "scene": scene.identity(),
        "numerics": numerics.to_dict(),
        "seed": scene.ensemble.seed,
        "stream": numerics.stream,
        "versions": versions(),
        "threads": numerics.threads,
        "residual": residual,
        "iterations": iterations,
        "seconds": seconds,
        "written": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
    }
