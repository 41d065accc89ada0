"""Plant single-character errors in formulas and kernels, one at a time, and see whether a test notices.

    python tests/mutate.py [--only WORD ...] [--seed S] [--each N] [--list]

Each error is planted in a private copy of the sources, and the tests of that file are run on it until one fails. A
digit grows by one, + and − or * and / change places, < becomes > (or loses its =), ** becomes *. What stands in
EQUAL is no error: the result is the same, only the way to it differs. Not collected by pytest: it takes some minutes.
"""

from __future__ import annotations

import argparse
import io
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
# file → its tests, the quickest to notice first
TESTS = {
    "theory/persson.py": "theory/test_theory_persson.py theory/test_theory_stress.py theory/test_theory_flash.py",
    "theory/flash.py": "theory/test_theory_flash.py theory/test_theory_skin.py",
    "theory/directions.py": "theory/test_theory_flash.py",
    "theory/skin.py": "theory/test_theory_skin.py",
    "theory/hankel.py": "theory/test_theory_stress.py theory/test_theory_persson.py",
    "theory/plasticity.py": "theory/test_theory_plasticity.py theory/test_theory_stress.py",
    "theory/interface.py": "theory/test_interface.py theory/test_scattering.py theory/test_yielding.py",
    "theory/scattering.py": "theory/test_scattering.py theory/test_yielding.py test_yielding_points.py",
    "theory/yielding.py": "theory/test_yielding.py theory/test_yielding_range.py test_yielding_points.py",
    "theory/clipped/drawing.py": "theory/test_clipped_temperatures.py",
    "theory/clipped/distribution.py": "theory/test_clipped_temperatures.py",
    "theory/clipped/temperatures.py": "theory/test_clipped_temperatures.py",
    "theory/clipped/sliding.py": "theory/test_clipped_sliding.py",
    "theory/clipped/two_faces.py": "theory/test_clipped_sliding.py",
    "theory/memory.py": "theory/test_memory.py theory/test_two_bodies.py",
    "theory/clipped/products.py": "theory/test_memory.py theory/test_two_bodies.py",
    "theory/clipped/field.py": "theory/test_clipped.py theory/test_memory.py",
    "theory/layered_memory.py": "theory/test_two_bodies_skin.py",
    "theory/two_bodies.py": "theory/test_two_bodies.py",
    "theory/full_contact.py": "theory/test_theory_persson.py theory/test_theory_plasticity.py",
    "theory/walls.py": "theory/test_theory_plasticity.py theory/test_yielding.py",
    "theory/partition.py": "theory/test_theory_heat_balance.py theory/test_theory_skin.py",
    "theory/background.py": "theory/test_theory_heat_balance.py theory/test_theory_skin.py",
    "theory/classical.py": "theory/test_theory_classical.py",
    "theory/hardness.py": "theory/test_theory_hardness.py",
    "theory/quadrature.py": "theory/test_theory_quadrature.py theory/test_theory_range.py",
    "theory/hertz/limits.py": "theory/test_theory_hertz.py",
    "theory/hertz/graded.py": "theory/test_theory_hertz.py",
    "theory/hertz/moments.py": "theory/test_theory_hertz.py",
    "theory/hertz/maximum.py": "theory/test_theory_hertz.py",
    "roughsim/grid.py": "test_grid.py test_modes.py observables/test_moments.py",
    "roughsim/surface/spectrum.py": "surface/test_spectrum.py surface/test_spectrum_refused.py",
    "roughsim/surface/power_laws.py": "surface/test_spectrum.py surface/test_spectrum_refused.py",
    "roughsim/surface/synthesis.py": "surface/test_surface.py surface/test_draws.py",
    "roughsim/fourier/convolution.py": "heat/test_half_space.py heat/test_partition.py",
    "roughsim/contact/patches.py": "contact/test_patches.py",
    "roughsim/contact/solver/operators.py": (
        "contact/test_contact_operator.py contact/test_contact.py contact/test_contact_solver.py"
    ),
    "roughsim/contact/solver/problem.py": "contact/test_contact.py contact/test_contact_cases.py",
    "roughsim/contact/plasticity.py": "contact/test_plasticity.py",
    "roughsim/heat/skin.py": "heat/test_skin.py observables/test_layered_moments.py",
    "roughsim/heat/laplace.py": "heat/test_skin.py heat/test_layered_history.py",
    "roughsim/heat/layered_influence.py": "heat/test_skin_half_space.py",
    "roughsim/heat/periodic.py": (
        "heat/test_heat.py heat/test_heat_time.py heat/test_heat_symmetry.py heat/test_heat_errors.py"
    ),
    "roughsim/heat/waves.py": "heat/test_heat_time.py heat/test_heat_errors.py theory/test_theory_skin.py",
    "roughsim/heat/history.py": "heat/test_history.py",
    "roughsim/heat/layered_history.py": "heat/test_layered_history.py",
    "roughsim/heat/equal_temperatures.py": "heat/test_equal_temperatures.py heat/test_partition.py",
    "roughsim/heat/arguments.py": "heat/test_heat_arguments.py heat/test_heat_time.py",
    "roughsim/heat/influence.py": "heat/test_half_space.py heat/test_source.py heat/test_partition.py",
    "roughsim/heat/half_space.py": "heat/test_half_space.py heat/test_source.py",
    "roughsim/heat/partition.py": "heat/test_equal_temperatures.py heat/test_partition.py",
    "roughsim/heat/statistics.py": "heat/test_heat_statistics.py heat/test_heat_fields.py",
    "roughsim/observables/moments.py": "observables/test_moments.py observables/test_angular.py",
    "roughsim/observables/stress_spectrum.py": "observables/test_stress_spectrum.py observables/test_moments.py",
    "roughsim/scene/model.py": (
        "heat/test_conductivity.py scene/test_scene_bodies.py scene/test_scene.py scene/test_scene_identity.py"
    ),
    "roughsim/observables/distribution.py": "observables/test_distribution.py",
    "roughsim/observables/temperatures.py": "observables/test_distribution.py",
    "roughsim/observables/record.py": "observables/test_observable_record.py estimate/test_influence.py",
    "roughsim/observables/catalogue.py": "estimate/test_influence.py estimate/test_levels.py",
    "roughsim/scene/spectra/k_correlation.py": "surface/test_spectrum.py",
    "roughsim/estimate/mean.py": "estimate/test_mean.py",
    "roughsim/estimate/ladder.py": "estimate/test_ladder.py estimate/test_levels.py",
    "roughsim/estimate/limit.py": "estimate/test_limit.py estimate/test_levels.py",
    "roughsim/estimate/levels.py": "estimate/test_levels.py",
    "roughsim/estimate/rounds.py": "estimate/test_rounds.py estimate/test_next_round.py",
    "roughsim/estimate/errors.py": "estimate/test_errors.py",
    "roughsim/estimate/regression.py": "estimate/test_regression.py",
    "roughsim/estimate/correlation.py": "estimate/test_correlation.py",
    "roughsim/estimate/sliding.py": "estimate/test_sliding.py",
    "roughsim/prediction/theories.py": "prediction/test_prediction.py prediction/test_one_theory.py",
    "roughsim/prediction/modes.py": "prediction/test_prediction.py prediction/test_one_theory.py",
    "roughsim/prediction/bodies.py": (
        "prediction/test_friction.py heat/test_conductivity.py prediction/test_prediction.py "
        "comparison/test_contact_temperature.py"
    ),
    "roughsim/comparison/compare.py": (
        "comparison/test_compare.py comparison/test_contact_temperature.py comparison/test_in_band.py "
        "estimate/test_total_errors.py"
    ),
    "roughsim/show/table.py": "show/test_units.py show/test_table.py",
    "roughsim/comparison/trust.py": "comparison/test_trust.py",
    "roughsim/planning/levels.py": "planning/test_ladders.py",
    "roughsim/planning/plan.py": "planning/test_plan.py",
    "roughsim/scene/numerics.py": "scene/test_numerics.py",
    "roughsim/estimate/cell_size.py": "estimate/test_cell.py",
    "roughsim/_kernels/active_set.py": (
        "kernels/test_kernels.py contact/test_contact_solver.py contact/test_contact.py contact/test_contact_cases.py"
    ),
    "roughsim/_kernels/extension.py": "contact/test_contact_operator.py contact/test_contact_solver.py",
    "roughsim/_kernels/interpolation.py": "contact/test_contact_operator.py contact/test_contact_solver.py",
    "roughsim/_kernels/lines.py": (
        "kernels/test_kernels.py contact/test_contact_operator.py contact/test_contact_solver.py "
        "heat/test_half_space.py"
    ),
}
SWAPS = {"+": "-", "-": "+", "*": "/", "/": "*", "<": ">", ">": "<", "<=": "<", ">=": ">", "**": "*"}
# lines whose numbers may change without changing a result: sizes of blocks and caches, starts of iterations, limits of
# what is worth while; errors there cost time, or guard against what no input reaches
EQUAL: tuple[tuple[str, str], ...] = (
    ("theory/background.py", "quad(flux, low, high, epsabs=0.0, epsrel=_ACCURACY / 10, limit=500, full_output=1)"),
    # what is left of a way is rounding
    ("theory/clipped/two_faces.py", "while left > 1e-6 * shortest:"),
    # a tolerance below rounding stops at rounding
    ("theory/hardness.py", "accuracy = 1e-12 * max(abs(start), 1.0)"),
    # at the last temperature both refuse
    ("theory/hardness.py", "if not temperatures[0] <= start <= temperatures[-1]:"),
    # one place more stays empty
    ("roughsim/grid.py", "present = np.zeros(square.max() + 1, np.bool_)"),
    # the zeros that reach too far are written over by the next line
    (
        "roughsim/fourier/convolution.py",
        "field[:, :count], field[:, count : points - count + 1] = part[:, before:], 0.0",
    ),
)


class Mutant(NamedTuple):
    """One planted error."""

    file: str
    line: int
    old: str
    new: str
    text: str  # of the whole file

    @property
    def name(self) -> str:
        """Where it is and what it changes."""
        return f"{self.file}:{self.line}: {self.old.strip()}  →  {self.new.strip()}"


def changed(token: tokenize.TokenInfo) -> str | None:
    """What a token becomes, None if it stays."""
    if token.type == tokenize.OP:
        return SWAPS.get(token.string)
    if token.type == tokenize.NUMBER:
        place = next((i for i, c in enumerate(token.string) if c in "123456789"), None)
        if place is None:
            return token.string.replace("0", "1", 1)
        return token.string[:place] + str((int(token.string[place]) + 1) % 10) + token.string[place + 1 :]
    return None


def mutants(file: str) -> Iterator[Mutant]:
    """All errors that can be planted in a file: in code that computes, not in signatures and messages."""
    source = (ROOT / file).read_text()
    lines = source.splitlines(keepends=True)
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        new = changed(token)
        if new is None:
            continue
        row, column = token.start
        line = lines[row - 1]
        if not line.startswith(" ") or _is_no_formula(line, token) or (file, line.strip()) in EQUAL:
            continue
        other = line[:column] + new + line[column + len(token.string) :]
        text = "".join([*lines[: row - 1], other, *lines[row:]])
        try:
            compile(text, file, "exec")
        except (SyntaxError, SyntaxWarning):
            continue
        yield Mutant(file, row, line, other, text)


def _is_no_formula(line: str, token: tokenize.TokenInfo) -> bool:
    words = ("raise ", "def ", "->", "import ", 'f"', "warn(", "__", "lru_cache", "axis=", "range(", "shape")
    column = token.start[1]
    unpacks = token.string in ("*", "**") and line[:column].rstrip()[-1:] in ("(", ",", "[", "{", "")
    annotates = token.string == "=" or ": float = " in line or ": int = " in line
    return unpacks or annotates or any(word in line for word in words)


def drawn(each: int, seed: int, only: list[str]) -> list[Mutant]:
    """A few errors of every file, of different lines, the same for the same seed."""
    result = []
    for file in TESTS:
        if not any(word in file for word in only):
            continue
        found = list(mutants(file))
        rng = random.Random(f"{seed} {file}")
        rng.shuffle(found)
        lines: set[int] = set()
        for mutant in found:
            if len(lines) < each and mutant.line not in lines:
                lines.add(mutant.line)
                result.append(mutant)
    return result


def noticed(mutant: Mutant, copy: Path, caches: Path) -> bool:
    """Whether a test fails on the copy with the error planted."""
    place = copy / mutant.file
    genuine = place.read_text()
    # numba looks at the changed file alone: a kernel that it is compiled into would be taken from the cache
    cache = caches / (f"{time.monotonic_ns()}" if "_kernels" in mutant.file else "shared")
    place.write_text(mutant.text)
    try:
        return not _pass(copy, TESTS[mutant.file], cache)
    finally:
        place.write_text(genuine)


def _pass(copy: Path, tests: str, cache: Path) -> bool:
    # what looks at the clock or starts processes may fail for reasons of its own
    steady = "not interrupt and not process and not threads and not work_hardly_grows and not two_solves"
    words = ["-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", "not slow", "-k", steady]
    paths = [str(copy / "tests" / test) for test in tests.split()]
    environment = {**os.environ, "PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": str(cache), "OMP_NUM_THREADS": "1"}
    environment["PYTHONDONTWRITEBYTECODE"] = "1"
    try:
        done = subprocess.run(
            [sys.executable, *words, *paths], cwd=copy, env=environment, capture_output=True, timeout=600, check=False
        )
    except subprocess.TimeoutExpired:
        return False  # an error that makes a solve endless is noticed
    if done.returncode in (4, 5):  # a word of the command is wrong, or there are no tests
        raise RuntimeError(f"the tests {tests} could not be run: {done.stdout.decode()[-2000:]}")
    return done.returncode == 0


def main() -> int:
    """Plant, run, report; exit code 1 below nine in ten."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--only", nargs="+", default=[""], metavar="WORD", help="files whose path holds one of these")
    options.add_argument("--seed", type=int, default=1, help="another draw")
    options.add_argument("--each", type=int, default=2, help="errors per file")
    options.add_argument("--list", action="store_true", help="show what would be planted")
    given = options.parse_args()
    chosen = drawn(given.each, given.seed, given.only)
    if given.list:
        print("\n".join(mutant.name for mutant in chosen))
        return 0
    missed = []
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        copy = Path(folder) / "copy"
        ignored = shutil.ignore_patterns("__pycache__", ".git", ".venv", "runs", "out", "build")
        shutil.copytree(ROOT, copy, ignore=ignored)
        for tests in dict.fromkeys(TESTS[mutant.file] for mutant in chosen):
            if not _pass(copy, tests, Path(folder) / "shared"):
                raise RuntimeError(f"the tests {tests} fail without any error planted")
        for count, mutant in enumerate(chosen, start=1):
            caught = noticed(mutant, copy, Path(folder))
            missed += [] if caught else [mutant]
            print(f"{count}/{len(chosen)} {'caught' if caught else 'MISSED'} {mutant.name}", flush=True)
    share = 1 - len(missed) / len(chosen)
    print(f"{len(chosen)} planted, {len(chosen) - len(missed)} caught: {100 * share:.1f} %")
    print("\n".join(f"missed: {mutant.name}" for mutant in missed))
    return 0 if share >= 0.9 else 1


if __name__ == "__main__":
    sys.exit(main())
