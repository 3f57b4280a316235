"""Linear regression of few variables."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean

RIDGE = 1.0
"""Keeps slopes small of which the data say nothing: as if each variable had varied by 1 once, without an effect."""


def regression(rows: Sequence[Sequence[float]], values: Sequence[float]) -> list[float]:
    """The slope of a value along each variable, by least squares (ridge regression).

    Args:
        rows: the variables of each observation.
        values: of the observations.
    """
    if not rows or not rows[0]:
        return []
    size, means = len(rows[0]), [fmean(column) for column in zip(*rows, strict=True)]
    centred = [[each - mean for each, mean in zip(row, means, strict=True)] for row in rows]
    mean = fmean(values)
    matrix = [
        [sum(row[i] * row[j] for row in centred) + RIDGE * (i == j) for j in range(size)]
        + [sum(row[i] * (value - mean) for row, value in zip(centred, values, strict=True))]
        for i in range(size)
    ]
    for i in range(size):  # Gauss and Jordan; no pivot is 0, for the ridge makes the matrix positive definite
        pivot = matrix[i][i]
        matrix[i] = [each / pivot for each in matrix[i]]
        for j in range(size):
            if j != i:
                matrix[j] = [a - matrix[j][i] * b for a, b in zip(matrix[j], matrix[i], strict=True)]
    return [row[size] for row in matrix]
