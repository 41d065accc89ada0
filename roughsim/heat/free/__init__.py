"""Heat on the free half-space: one source and nothing around it.

`half_space` gives the field from the `influence` of each pixel, `source` T_flash, T_av and T_max between the centres of
pixels too, and `partition` shares the heat between two bodies.
"""
