"""Rough surfaces: their power spectra, their synthesis, and measured ones."""
