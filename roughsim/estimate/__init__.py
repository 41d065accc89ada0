"""From members to one value with its errors: levels, extrapolation, statistics, and the size of the cell."""
