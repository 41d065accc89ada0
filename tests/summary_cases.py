"""The run of two levels that summaries and gaps are tested with (`whole` in tests/results/conftest.py)."""

COUNT = 9  # realizations
