"""Fourier transforms, the one door to FFTW, and what is done block by block around them.

`plans` transforms whole fields, rows and lines, `convolution` multiplies spectra while they are in the cache, and
`blocks` shares work on one array out among threads.
"""

from roughsim.fourier.plans import Transform, backend, direct, forward, get_threads, inverse, set_threads

__all__ = ["Transform", "backend", "direct", "forward", "get_threads", "inverse", "set_threads"]
