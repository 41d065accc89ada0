"""Contacts solved on ladders of grids, to compare the theory with: their members, limits and errors."""
