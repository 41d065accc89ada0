"""Observables of a solved contact, with their storage, averages and theory."""
