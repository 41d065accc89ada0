"""Fourier transforms, the one door to FFTW, and what is done block by block around them.

`library` is FFTW itself, `plans` transforms whole fields, rows and lines, `convolution` multiplies spectra while they
are in the cache, and `blocks` shares work on one array out among threads.
"""

from roughsim.fourier.library import backend, direct, get_threads, set_threads
from roughsim.fourier.plans import Transform, forward, inverse

__all__ = ["Transform", "backend", "direct", "forward", "get_threads", "inverse", "set_threads"]
