"""Scenes small enough to run in a test, and the conditions that several tests set for them."""

import contextlib
import importlib
import os
import sys
from dataclasses import replace
from fnmatch import fnmatch
from functools import partial

import numpy as np
import pytest
from process_cases import end_processes
from slide_cases import sliding_scene
from small_scene import CAPPED, FULL

import roughsim as rs
from roughsim.machine import Available
from roughsim.scene import parse_scene


@pytest.hookimpl(optionalhook=True)  # of xdist
def pytest_xdist_setupnodes():
    """Compiles the solver once, where each process of tests would compile it at the same time.

    BLAS has one thread in each: several would wait for one another in a loop, as the cores are taken.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    heights = np.random.default_rng(0).standard_normal((32, 32))
    solid, grid = rs.Solid(1.0, 0.1), rs.Grid((32, 32), (100.0, 100.0))
    rs.solve_contact(heights, grid, solid, nominal_pressure=0.01)


@pytest.hookimpl(optionalhook=True)  # of xdist
def pytest_xdist_make_scheduler(config, log):
    """Gives all tests of a file to one process: the runs and studies that they share are computed once."""
    from xdist.scheduler import LoadFileScheduling

    return LoadFileScheduling(config, log)


@pytest.fixture(scope="session")
def steel():
    return rs.load_scene("steel-1.2GPa")


@pytest.fixture(scope="session")
def capped_scene():
    return parse_scene(CAPPED)


@pytest.fixture(scope="session")
def full_scene():
    return parse_scene(FULL)


@pytest.fixture(scope="session")
def capped_run(capped_scene, tmp_path_factory):
    """A finished run; tests only read it."""
    return rs.run(capped_scene, tmp_path_factory.mktemp("runs") / "capped")


@pytest.fixture(scope="session")
def sliding_run(tmp_path_factory):
    """A finished run whose faces slide; tests only read it."""
    return rs.run(sliding_scene(), tmp_path_factory.mktemp("runs") / "sliding")


@pytest.fixture(scope="module")
def few_fields():
    """Contacts drawn by the law are few and of few points: what is looked at is where their numbers stand."""
    drawn = importlib.import_module("roughsim.prediction.fields")
    remembered = drawn.frozen_fields, drawn.slid_fields, drawn.drawn_pictures
    for one in remembered:
        one.cache_clear()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(drawn, "draw_frozen", partial(drawn.draw_frozen, points=256, fields=6))
        patch.setattr(drawn, "draw_slides", partial(drawn.draw_slides, points=64, fields=6))
        patch.setattr(drawn, "_POINTS", 256)  # of pictures
        patch.setattr(drawn, "_FIELDS", 4)
        yield
    for one in remembered:
        one.cache_clear()


@pytest.fixture
def quick(capped_scene):
    """The smallest scene that runs: one level of 32 × 32."""
    numerics = replace(
        capped_scene.numerics,
        levels=({"column": "capped", "shape": [32, 32], "q_max": 4e4},),
        keep_fields=1,
    )
    return replace(capped_scene, numerics=numerics)


@pytest.fixture
def drawn(monkeypatch):
    """The figures of charts, in place of their files."""
    from roughsim.charts import style

    figures = []
    monkeypatch.setattr(style, "save", lambda figure, path: figures.append(figure))
    return figures


@pytest.fixture(autouse=True)
def _no_process_outlives_its_test():
    yield
    end_processes()


@pytest.fixture
def no_pictures(monkeypatch):
    """Pages without pictures, which take their time and are looked at in one test."""
    from roughsim.outputs import run_report, study_report
    from roughsim.show.markup import tag

    for report in (run_report, study_report):
        monkeypatch.setattr(report, "picture", lambda draw, ending, caption: tag("figure", caption))


@pytest.fixture
def in_tmp_path(tmp_path):
    """The test runs in its own folder."""
    with contextlib.chdir(tmp_path):
        yield


@pytest.fixture
def soon(monkeypatch):
    """Short times, so that the end of a process is noticed within a test."""
    monkeypatch.setattr("roughsim.store.claims.LEASE", 0.3)
    monkeypatch.setattr("roughsim.store.claims.RENEWAL", 0.03)
    monkeypatch.setattr("roughsim.ensemble.tasks.PAUSE", 0.01)


@pytest.fixture
def one_by_one(monkeypatch):
    """Each member is a batch, and is saved at once."""
    monkeypatch.setattr("roughsim.ensemble.tasks.BATCH", 0.0)
    monkeypatch.setattr("roughsim.ensemble.tasks.INTERVAL", 0.0)
    monkeypatch.setattr("roughsim.ensemble.tasks.SHARE", 1e9)


@pytest.fixture
def failing(monkeypatch):
    """Contact solves that do not converge: `failing(which)` chooses them by their problem."""
    from roughsim.ensemble import sources

    genuine = sources.solve_problem

    def solves_fail(which):
        def solve(problem, *rest):
            if which(problem):
                raise rs.ConvergenceError("contact solve stalled: residual 0.1", 0.1, 7)
            return genuine(problem, *rest)

        monkeypatch.setattr(sources, "solve_problem", solve)

    return solves_fail


@pytest.fixture
def memory(monkeypatch):
    """A machine with so many bytes of memory: `memory(amount)`."""

    def limited(amount):
        names = (
            "machine",
            "untrusted",
            "error_over_cost",
            "planning.levels",
            "planning.reasons",
            "ensemble.executors",
            "results.folder",
        )
        # all are imported first: one imported later would keep the patched function
        for module in [importlib.import_module(f"roughsim.{name}") for name in names]:
            monkeypatch.setattr(
                module, "available_memory", lambda: Available(amount, "limit of the test")
            )

    return limited


@pytest.fixture
def without(monkeypatch):
    """An environment that lacks a package: `without(name)`."""
    return lambda name: monkeypatch.setitem(sys.modules, name, None)


@pytest.fixture
def unreadable(monkeypatch):
    """Files that the system does not open: ``with unreadable(pattern, number):`` an error number for such names."""

    @contextlib.contextmanager
    def refused(pattern, number):
        genuine = open

        def refuse(file, *given, **named):
            if fnmatch(str(file), pattern):
                raise OSError(number, os.strerror(number), str(file))
            return genuine(file, *given, **named)

        with monkeypatch.context() as system:
            system.setattr("builtins.open", refuse)
            yield

    return refused


@pytest.fixture
def calls(monkeypatch):
    """Counts the calls of a function of a module: each adds its arguments to the list that is returned."""

    def counted(module, name):
        made, function = [], getattr(module, name)
        monkeypatch.setattr(module, name, lambda *rest: made.append(rest) or function(*rest))
        return made

    return counted


@pytest.fixture
def theory_table(monkeypatch):
    """Sets the function that computes the table of `roughsim theory`."""
    return lambda function: monkeypatch.setattr("roughsim.comparison.theory.theory_table", function)


@pytest.fixture
def install(monkeypatch, tmp_path):
    """Puts a package on the path of this process: `install(name, requires, entry_points, modules)`."""
    site = tmp_path / "site-packages"
    site.mkdir()
    monkeypatch.syspath_prepend(site)

    def package(name, requires=(), entry_points=None, modules=None):
        about = site / f"{name}-1.0.dist-info"
        about.mkdir(exist_ok=True)
        needs = [f"Requires-Dist: {one}" for one in requires]
        (about / "METADATA").write_text(
            "\n".join(["Metadata-Version: 2.1", f"Name: {name}", "Version: 1.0", *needs, ""])
        )
        lines = []
        for group, entries in (entry_points or {}).items():
            lines += [f"[{group}]", *(f"{key} = {target}" for key, target in entries.items())]
        (about / "entry_points.txt").write_text("\n".join([*lines, ""]))
        for module, source in (modules or {}).items():
            (site / f"{module}.py").write_text(source)

    return package
