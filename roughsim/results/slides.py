"""The counted members of the column sliding."""

from dataclasses import replace

import numpy as np

from roughsim.estimate.ladder import Pair
from roughsim.estimate.levels import FLASH
from roughsim.estimate.sliding import SLIDING_OBSERVABLES
from roughsim.grid import Array
from roughsim.observables.catalogue import AXIS, OBSERVABLES
from roughsim.results.members import Members
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics
from roughsim.sliding.path import coarser_grid
from roughsim.store.member_files import member_path, read_member


def curves(members: Members) -> dict[str, Array]:
    """Return the curves of the slides, stacked over the members, and their axis; ValueError without a sound member."""
    level, indices = _sound(members)
    rows = [read_member(member_path(members.folder, level, index)).curves for index in indices]
    return {name: np.stack([row[name] for row in rows]) for name in rows[0]} | {AXIS: rows[0][AXIS]}


def coarsening(members: Members) -> float:
    """Return the ratio of pixels of slides, coarser grid over own grid; 1 without a coarser grid."""
    level = _sound(members)[0]
    grid = members.numerics.grid(level)
    coarser = coarser_grid(grid, members.numerics.levels[level].q_max)
    return 1.0 if coarser is None else coarser.spacing[0] / grid.spacing[0]


def pair(members: Members) -> Pair:
    """Return the sample of the slides, with their T_flash as that of contacts; ValueError without one."""
    level = _sound(members)[0]
    sample = members.sample(level)
    slid = sample.numbers | {FLASH: sample.numbers["sliding_flash_temperature"]}
    return Pair(level, members.numerics.stream(level), replace(sample, numbers=slid), None)


def followed(scene: Scene, numerics: Numerics) -> float | None:
    """Return the distance that slides are followed, m, if it is less than the whole slid distance; else None."""
    distance = None if numerics.slide is None else numerics.levels[numerics.slide].followed
    return distance if distance is not None and distance < max(scene.sliding.distances) else None


def observables(members: Members) -> tuple[str, ...]:
    """Return the observables of the column: those of the distribution only if its members have stored them."""
    if not have_distribution(members):
        return SLIDING_OBSERVABLES
    return (*SLIDING_OBSERVABLES, *(name for name, record in OBSERVABLES.items() if record.asked))


def have_distribution(members: Members) -> bool:
    """Return whether there are slides, and all have stored the distribution of the temperature."""
    level = members.numerics.slide
    if level is None:
        return False
    indices = members.sound(level)
    return bool(indices) and all(members[level, index].bins is not None for index in indices)


def _sound(members: Members) -> tuple[int, list[int]]:
    """Return the level of slides, and its sound members; ValueError if there is none."""
    level = members.numerics.slide
    if level is None:
        raise ValueError(f'{members.folder} has no column "sliding": its scene has history = "frozen"')
    if sound := members.sound(level):
        return level, sound
    raise ValueError(f"{members.folder} has no sound member that slides yet; let it run first")
