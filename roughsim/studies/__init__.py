"""Studies: one scene computed for a grid of values, each point an ordinary run, with one table of all."""
