"""How far two bodies slide while a contact spot lives."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughsim.contact.patches import RESOLVED, labelled_patches
from roughsim.grid import Array


class Lives(NamedTuple):
    """Contact spots that were born, and have died, while they were watched."""

    distance: Array  # slid between the first and the last position of each, and half a step before and after, m
    pixels: Array  # mean size of each over its life
    unfinished: int  # spots that were there at the first or at the last position: their life is longer than was seen
    so_far: Array  # m, of those that were born and are there at the last position
    so_far_pixels: Array  # mean size of each until then


class SpotLives:
    """Follows the contact spots of two sliding bodies from position to position, by overlap.

    A spot goes on as the one that it shares most pixels with at the next position. If several go on as one, the one
    that shares most lives on in it, and the others have died. If one goes on as several, it lives on in the one that it
    shares most with, and the others are born. The steps must be shorter than the spots: one pixel is.
    """

    def __init__(self) -> None:
        self._labels: NDArray[np.int64] | None = None
        self._born: Array = np.zeros(
            0
        )  # slid distance at which each spot of the latest position was born; NaN: before
        self._sizes: Array = np.zeros(0)  # pixels of each, summed over its positions
        self._positions: Array = np.zeros(0)
        self._distances: list[Array] = []
        self._mean_pixels: list[Array] = []
        self._last = np.nan
        self._unseen = 0

    def add(self, slid_distance: float, touching: NDArray[np.bool_]) -> None:
        """Take the next position: its slid distance, m, further than the last, and its mask of contact."""
        labels, count = labelled_patches(touching)
        pixels = np.bincount(labels.ravel(), minlength=count + 1)[1:].astype(float)
        if self._labels is None:
            born = np.full(count, np.nan)
            sizes = pixels
            positions = np.ones(count)
        else:
            middle = (self._last + slid_distance) / 2
            heir = _successors(self._labels, self._born.size, labels, count)
            lives_on = heir >= 0
            self._bury(~lives_on, middle)
            born = np.full(count, middle)
            sizes = pixels
            positions = np.ones(count)
            born[heir[lives_on]] = self._born[lives_on]
            sizes[heir[lives_on]] += self._sizes[lives_on]
            positions[heir[lives_on]] += self._positions[lives_on]
        self._labels = labels
        self._last = slid_distance
        self._born = born
        self._sizes = sizes
        self._positions = positions

    def _bury(self, dead: NDArray[np.bool_], distance: float) -> None:
        """Keep the lives of those that ended here and whose birth was seen."""
        seen = dead & np.isfinite(self._born)
        self._distances.append(distance - self._born[seen])
        self._mean_pixels.append(self._sizes[seen] / self._positions[seen])
        self._unseen += int(dead.sum() - seen.sum())

    def lives(self) -> Lives:
        """Return the lives that began and ended between the first and the latest position."""
        nothing = np.zeros(0)
        born = np.isfinite(self._born)
        return Lives(
            np.concatenate([nothing, *self._distances]),
            np.concatenate([nothing, *self._mean_pixels]),
            self._unseen + self._born.size,
            self._last - self._born[born],
            self._sizes[born] / self._positions[born],
        )


def survival(lives: Lives, distance: Array) -> Array:
    """Return the share of contact spots that live for longer than a distance, m; NaN if none was observed so long.

    Spots of `RESOLVED` pixels or more count, on the mean over their life. Spots of the first position do not count,
    since their birth was not observed. Spots of the last position count for their observed life: they are censored
    (Kaplan & Meier, J. Am. Stat. Assoc. 53, 1958, 457).
    """
    ends = np.sort(lives.distance[lives.pixels >= RESOLVED])
    so_far = np.sort(lives.so_far[lives.so_far_pixels >= RESOLVED])
    # of the spots observed for so long, each that ends takes its part
    censored = so_far.size - np.searchsorted(so_far, ends)
    watched = np.arange(ends.size, 0, -1) + censored
    share = np.concatenate([[1.0], np.cumprod(1.0 - 1.0 / watched)])
    # distances and lives are whole steps, to rounding
    ended = np.searchsorted(ends, distance * (1 + 1e-9), side="right")
    result: Array = share[ended]
    longest = max([*ends[-1:], *so_far[-1:]], default=0.0)
    unknown = (distance > longest * (1 + 1e-9)) & (share[-1] > 0.0)
    result[unknown] = np.nan
    return result


def _successors(
    labels: NDArray[np.int64], count: int, later: NDArray[np.int64], later_count: int
) -> NDArray[np.intp]:
    """Return for each spot the index of the later one in which it lives on, −1 if it has died."""
    shared = (labels > 0) & (later > 0)
    pair = (labels[shared] - 1) * later_count + later[shared] - 1
    pairs, pixels = np.unique(pair, return_counts=True)
    earlier, heirs = np.divmod(pairs, max(later_count, 1))
    heir = [-1] * count
    taken = [False] * later_count
    # the pairs that share most come first; each spot has one heir, each heir one forerunner
    order = np.argsort(-pixels, kind="stable")
    for before, after in zip(earlier[order].tolist(), heirs[order].tolist(), strict=True):
        if heir[before] < 0 and not taken[after]:
            heir[before] = after
            taken[after] = True
    return np.array(heir, np.intp)
