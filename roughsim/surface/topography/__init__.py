"""Measured surfaces: reading the files of instruments, measuring C(q) with its error, and writing for other programs.

`reading` gives heights of one file, `measured` the C(q) of one map or of several, `texture` how a map differs from
surfaces drawn from that C(q), `writing` files for other programs.
Formats of instruments are read through SurfaceTopography, the extra `topography`, which also combines several scans.
Its C(q) is 4π² larger than ours: it has ⟨h²⟩ = ∫ C d²q/(2π)², we have ⟨h²⟩ = ∫ C d²q (see `roughsim`).
"""

from roughsim.surface.topography.measured import MeasuredSpectrum, combined, map_spectrum, radial_average
from roughsim.surface.topography.reading import Topography, is_plain, levelled, read_topography
from roughsim.surface.topography.texture import Texture, texture_of
from roughsim.surface.topography.writing import ENDINGS, encoded

__all__ = [
    "ENDINGS",
    "MeasuredSpectrum",
    "Texture",
    "Topography",
    "combined",
    "encoded",
    "is_plain",
    "levelled",
    "map_spectrum",
    "radial_average",
    "read_topography",
    "texture_of",
]
