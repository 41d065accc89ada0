"""Work in blocks: the same result as on the whole plane, for any number of threads."""

import numpy as np
import pytest

from roughsim import fourier
from roughsim.fourier import blocks


@pytest.fixture(params=[1, 2])
def threads(request):
    before = fourier.get_threads()
    fourier.set_threads(request.param)
    yield request.param
    fourier.set_threads(before)


@pytest.mark.parametrize("place", [0, 350_000, 699_999])
def test_extremes_are_those_of_the_plane_in_whichever_block_they_lie(threads, place):
    field = np.random.default_rng(1).random((700, 1000))  # three blocks
    field.flat[place], field.flat[-1 - place] = 5.0, -3.0
    assert len(blocks.spans(*field.shape)) == 3
    assert blocks.extremes(field) == (-3.0, 5.0)
