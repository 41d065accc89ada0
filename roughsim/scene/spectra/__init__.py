"""Spectra C(q) that a scene can name: ``spectrum = { name = "...", ... }`` in a section with a roughness."""
