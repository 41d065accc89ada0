"""The inside of `solve_contact`: one grid after the other, each by conjugate gradients on an active set.

`problem` is what is solved, in its own units, and `cascade` goes from coarse grids to the finest. `solve` iterates on
one of them, `state` holds its fields. `pivoting` is for problems where clipped steps get nowhere; `preconditioner` and
`half_space` are the two products of a step.
"""
