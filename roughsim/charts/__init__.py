"""Figures, the one door to matplotlib: a comparison with the theory, and the pictures of a run."""

from roughsim.charts.comparison import comparison_chart
from roughsim.charts.pictures import QUANTITIES, plot_run
from roughsim.charts.trade import trade_chart

__all__ = ["QUANTITIES", "comparison_chart", "plot_run", "trade_chart"]
