"""What the tests of charts draw."""

from roughsim.charts.style import Subject

SPEED = ("temperature", "heat_flux", "distribution", "profile")


def subject(run, column="capped", speed=None, index=0):
    """A column of a run at its finest level."""
    return Subject(run, column, run.numerics.of_column(column)[-1], index, speed)
