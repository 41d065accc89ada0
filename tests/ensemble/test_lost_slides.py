"""Slides whose worker dies, in an executor of the caller."""

import multiprocessing
import os
import signal
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from slide_cases import sliding_scene
from stored_cases import members_of, read_member

import roughsim as rs

SLIDE = 1  # its level


def dies_on_the_way(work, *arguments):
    """What a worker does that is killed in the middle of a slide."""
    from roughsim.sliding import history

    genuine = history.walk

    def walk(*words):
        for n, step in enumerate(genuine(*words)):
            if n == 8:
                os.kill(os.getpid(), signal.SIGKILL)
            yield step

    history.walk = walk
    return work(*arguments)


class Dying(ProcessPoolExecutor):
    """One process, which is killed in its first slide."""

    def __init__(self):
        super().__init__(1, multiprocessing.get_context("spawn"))

    def submit(self, work, *arguments):
        return super().submit(dies_on_the_way, work, *arguments)


def assert_same(run, other):
    for index in (0, 1):
        mine, his = (read_member(one.folder, SLIDE, index) for one in (run, other))
        for name, values in his.numbers.items():
            np.testing.assert_array_equal(mine.numbers[name], values)
        for name, values in his.curves.items():
            np.testing.assert_array_equal(mine.curves[name], values)


@pytest.mark.slow
def test_a_worker_that_dies_in_a_slide_ends_the_run_with_a_sentence_and_the_next_goes_on(
    sliding_run, tmp_path
):
    with (
        Dying() as pool,
        pytest.raises(
            RuntimeError, match=r"the executor has lost a member .* the same call continues"
        ),
    ):
        rs.run(sliding_scene(), tmp_path / "run", executor=pool)
    assert SLIDE not in {level for level, _ in members_of(tmp_path / "run")}  # nothing half done
    assert not list((tmp_path / "run").glob("**/.*"))
    assert not (tmp_path / "run" / "claims").exists()
    again = rs.run(sliding_scene(), tmp_path / "run")
    assert again.realizations == 4
    assert_same(again, sliding_run)
