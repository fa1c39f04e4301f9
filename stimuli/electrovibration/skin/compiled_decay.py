"""A sum that decays, as a loop that numba compiles."""

from ...arrays import FloatArray
from ...compiled import entry


@entry
def decaying_sum(rows: FloatArray, factor: float) -> FloatArray:
    """(n_rows, n_samples): ``y_n = factor y_(n-1) + x_n`` along each row, from rest."""
    total = rows.copy()
    for i in range(rows.shape[0]):
        for n in range(1, rows.shape[1]):
            total[i, n] += factor * total[i, n - 1]
    return total
