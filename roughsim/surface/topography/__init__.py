"""Measured surfaces: reading the files of instruments, measuring C(q) with its error, and writing for other programs.

`reading` gives heights of one file: `text`, `netcdf` and `instruments` read its kinds, `undefined` fills its gaps.
`measured` gives C(q) of one map or of several, `profiles` C(q) of line scans, `texture` how a map differs from surfaces
drawn from its C(q), `writing` files for other programs. Formats of instruments are read through SurfaceTopography, the
extra `topography`, which also combines several scans. Its C(q) is 4π² larger than ours: it has ⟨h²⟩ = ∫ C d²q/(2π)², we
have ⟨h²⟩ = ∫ C d²q (see `roughsim`).
"""

from roughsim.surface.topography.measured import (
    MeasuredSpectrum,
    combined,
    levelled,
    map_spectrum,
    radial_average,
)
from roughsim.surface.topography.reading import (
    Profile,
    Topography,
    bins_of_lines,
    read_scan,
)
from roughsim.surface.topography.texture import Texture, texture_of
from roughsim.surface.topography.writing import ENDINGS, encoded

__all__ = [
    "ENDINGS",
    "MeasuredSpectrum",
    "Profile",
    "Texture",
    "Topography",
    "bins_of_lines",
    "combined",
    "encoded",
    "levelled",
    "map_spectrum",
    "radial_average",
    "read_scan",
    "texture_of",
]
