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


GIVEN = {"dependent": "y", "low": "low", "high": "high", "subject": "subject"}


def open_ended(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(low=np.nan, high=np.nan)


def cut(table: pd.DataFrame, at: float) -> pd.DataFrame:
    """Mark values below `at` as known only to lie below it."""
    below = table["y"] < at
    return table.assign(y=table["y"].where(~below), low=np.nan, high=np.where(below, at, np.nan))


def study(sizes, k, rng) -> pd.DataFrame:
    n = sum(sizes)
    table = pd.DataFrame(list(product(range(n), range(k))), columns=["subject", "freq"])
    group = np.repeat(np.arange(len(sizes)), sizes)
    values = rng.normal(size=(n, k)) * np.arange(1, k + 1) + rng.normal(size=(n, 1)) + group[:, None]
    return table.assign(y=values.ravel(), hand=np.array(["left", "right", "both"])[group][table["subject"]])
