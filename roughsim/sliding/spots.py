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
        # of each spot of the latest position: slid distance at its birth, NaN before the first position; its pixels
        # summed over its positions; and how many these are
        self._spots: Array = np.zeros((3, 0))
        self._ended: list[Array] = []  # life, m, and mean pixels, (2, spots) each
        self._last = np.nan
        self._unseen = 0

    def add(self, slid_distance: float, touching: NDArray[np.bool_]) -> None:
        """Take the next position: its slid distance, m, further than the last, and its mask of contact."""
        labels, count = labelled_patches(touching)
        pixels = np.bincount(labels.ravel(), minlength=count + 1)[1:].astype(float)
        middle = (self._last + slid_distance) / 2  # NaN at the first position
        spots = np.stack([np.full(count, middle), pixels, np.ones(count)])
        if self._labels is not None:
            heir = _successors(self._labels, self._spots.shape[1], labels, count)
            lives_on = heir >= 0
            ended = self._lives(~lives_on, middle)
            self._ended.append(ended)
            self._unseen += int((~lives_on).sum()) - ended.shape[1]
            spots[0, heir[lives_on]] = self._spots[0, lives_on]
            spots[1:, heir[lives_on]] += self._spots[1:, lives_on]
        self._labels = labels
        self._last = slid_distance
        self._spots = spots

    def lives(self) -> Lives:
        """Return the lives that began and ended between the first and the latest position."""
        ended = np.concatenate([np.zeros((2, 0)), *self._ended], axis=1)
        so_far = self._lives(True, self._last)
        unfinished = self._unseen + self._spots.shape[1]
        return Lives(ended[0], ended[1], unfinished, so_far[0], so_far[1])

    def _lives(self, which: NDArray[np.bool_] | bool, end: float) -> Array:
        """Return how long spots whose birth was seen have lived at a slid distance, m, and their mean pixels."""
        seen = which & np.isfinite(self._spots[0])
        born, pixels, positions = self._spots[:, seen]
        return np.stack([end - born, pixels / positions])


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
    result = share[ended]
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
