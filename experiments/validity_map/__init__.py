"""The parts of experiments/validity.py: members, elastic and capped points, the calibration, and the charts."""
