"""Figures, the one door to matplotlib: a comparison with the theory, and the pictures of a run."""

from roughsim.charts.comparison import comparison_chart
from roughsim.charts.error_over_cost import error_over_cost_chart
from roughsim.charts.plot import QUANTITIES, plot_run

__all__ = ["QUANTITIES", "comparison_chart", "error_over_cost_chart", "plot_run"]
