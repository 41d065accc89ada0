"""Figures: a comparison with the theory, the pictures of a run, error over cost. Only this room uses matplotlib."""

from roughsim.charts.comparison import comparison_chart
from roughsim.charts.error_over_cost import error_over_cost_chart
from roughsim.charts.plot import QUANTITIES, plot_run

__all__ = ["QUANTITIES", "comparison_chart", "error_over_cost_chart", "plot_run"]
