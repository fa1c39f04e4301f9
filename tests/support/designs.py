"""Random values of within-participant designs, as arrays and as long tables."""

from itertools import product

import numpy as np
import pandas as pd

NAMES = ("force", "freq", "speed")


def drawn(shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Draw correlated conditions of unequal variance by participant."""
    n_cells = int(np.prod(shape[1:]))
    mixing = rng.normal(size=(n_cells, n_cells))
    return (rng.normal(size=(shape[0], n_cells)) @ mixing + rng.normal(size=(shape[0], 1))).reshape(shape)


def long_table(values: np.ndarray) -> pd.DataFrame:
    keys = list(product(*(range(k) for k in values.shape)))
    return pd.DataFrame(keys, columns=["subject", *NAMES[: values.ndim - 1]]).assign(y=values.ravel())
