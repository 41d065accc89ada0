"""The inside of `solve_contact`: `solve` goes from coarse grids to the finest and iterates on each.

`problem` holds the problem in its own units, `steps` the parts of an iteration, `load` the offset for the load,
`exchange` the fallback for stalled solves, and `operators` the two products of a step.
"""
