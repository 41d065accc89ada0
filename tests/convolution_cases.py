"""Padded convolutions, and their definition as a sum over the field."""

import numpy as np

SHAPES = [
    ((5, 4), (9, 8)),
    ((3, 20), (5, 40)),
    ((1, 1), (1, 1)),
    ((7, 1), (15, 1)),
]  # of the field, and padded


def field_and_kernel(shape, padded):
    field, kernel = (np.random.default_rng(k).random(n) for k, n in enumerate((shape, padded)))
    return field, kernel


def sum_over_the_field(field, kernel):
    expected = np.zeros(field.shape)
    for i, j in np.ndindex(field.shape):
        for k, m in np.ndindex(field.shape):
            expected[i, j] += (
                field[k, m] * kernel[(i - k) % kernel.shape[0], (j - m) % kernel.shape[1]]
            )
    return expected
