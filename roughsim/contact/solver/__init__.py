"""The inside of `solve_contact`: `solve` goes from coarse grids to the finest and iterates on each.

`problem` holds what is solved, in its own units; `state` the fields of a solve; `operators` the two products of a step.
"""
