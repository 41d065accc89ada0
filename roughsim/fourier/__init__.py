"""Fourier transforms: the only place that calls FFTW.

`plans` transforms whole fields, rows and lines. `convolution` multiplies spectra while they are in the cache. `blocks`
shares the work on one array among threads.
"""

from roughsim.fourier.plans import (
    Transform,
    backend,
    direct,
    forward,
    get_threads,
    inverse,
    set_threads,
    transformed,
)

__all__ = [
    "Transform",
    "backend",
    "direct",
    "forward",
    "get_threads",
    "inverse",
    "set_threads",
    "transformed",
]
