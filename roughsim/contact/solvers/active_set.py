"""The package's own solver: elastic or capped, by a cascade of active sets (`roughsim.contact`)."""

from roughsim.contact import solve_contact as solve

__all__ = ["solve"]
