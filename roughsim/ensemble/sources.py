"""Sources of members: each level of a run has one, and a member follows from its index alone."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from roughsim.grid import Array
from roughsim.observables.catalogue import stored_numbers
from roughsim.observables.member import Member, StoredMoments
from roughsim.pipeline import Problem, Solution, Solved, solve_problem

if TYPE_CHECKING:  # a worker that slides loads it with the source; single contacts do without
    from roughsim.sliding.member import SlideProblem


class Source(Protocol):
    """The members of one level; it can be pickled, and has neither a scene nor files."""

    @property
    def level(self) -> int:
        """The number of the level."""

    @property
    def problem(self) -> "Problem | SlideProblem":
        """The problem of realization 0, with the seed, the random stream, the grid and the threads of all."""

    def solve(self, index: int, before: list[Solved], *, keep: bool) -> tuple[Member, list[Solved]]:
        """Compute a member, with its fields to `keep`, and return the contacts that it solved.

        Equal contacts solved `before`, by the source of another run, are taken from there.
        """


@dataclass(frozen=True, slots=True, eq=False)
class DrawnSurfaces:
    """Surfaces drawn from C(q), each solved at a level and at the level below it."""

    level: int
    problem: Problem
    below: Problem | None  # the level below, on the same surfaces

    def heights(self, problem: Problem) -> Array | None:
        """Return the heights of the realization `problem.index`, m, on its grid; None: they are drawn."""
        return None

    def about(self, problem: Problem, solution: Solution) -> Mapping[str, Any]:
        """Return additional values that a member stores, as JSON values."""
        return {}

    def solve(self, index: int, before: list[Solved], *, keep: bool) -> tuple[Member, list[Solved]]:
        """Solve the level after the level below it."""
        solved: list[Solved] = []
        moments = []
        accuracy = []
        for k, each in enumerate(each for each in (self.below, self.problem) if each is not None):
            problem = replace(each, index=index)
            start = solved[-1][1].contact if solved else None
            solution = solve_problem(
                problem, before[k] if before else None, self.heights(problem), start
            )
            solved.append((problem, solution))
            spectrum, distribution = solution.observables.stress_spectrum, solution.distribution
            bins = None if distribution is None else distribution.bins
            moments.append(
                StoredMoments(
                    stored_numbers(solution), spectrum.wavenumber, spectrum.variance, bins
                )
            )
            accuracy.append(
                {"residual": solution.contact.residual, "iterations": solution.contact.iterations}
            )
        seconds = {
            stage: sum(each.seconds[stage] for _, each in solved) for stage in solution.seconds
        }
        fields = {"heights": solution.heights, "pressure": solution.contact.pressure}
        member = Member(
            self.level,
            index,
            moments=tuple(reversed(moments)),
            fields={name: values.astype(np.float32) for name, values in fields.items() if keep},
            provenance={
                **accuracy[-1],
                **({} if self.below is None else {"below": accuracy[0]}),
                **self.about(problem, solution),
                "seconds": seconds,
            },
        )
        return member, solved


@dataclass(frozen=True, slots=True, eq=False)
class Slides:
    """Slides of one body over the other."""

    level: int
    problem: "SlideProblem"

    def solve(self, index: int, before: list[Solved], *, keep: bool) -> tuple[Member, list[Solved]]:
        """Compute a slide; it shares nothing with others."""
        from roughsim.sliding.member import solve_slide

        member = solve_slide(replace(self.problem, index=index), snapshots=keep)
        return replace(member, level=self.level), before
