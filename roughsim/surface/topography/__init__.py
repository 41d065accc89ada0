"""Measured surfaces: reading the files of instruments, measuring C(q) with its error, and writing for other programs.

`reading` gives heights of one file: `text`, `netcdf` and `instruments` read its kinds, `undefined` fills its gaps.
`measured` gives C(q) of one map or of several, `profiles` C(q) of line scans, `texture` how a map differs from surfaces
drawn from its C(q), `writing` files for other programs. Formats of instruments are read through SurfaceTopography, the
extra `topography`, which also combines several scans. Its C(q) is 4π² larger than ours: it has ⟨h²⟩ = ∫ C d²q/(2π)², we
have ⟨h²⟩ = ∫ C d²q (see `roughsim`).
"""
