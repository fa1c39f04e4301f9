"""Values of groups of participants in a within-participant design."""

from itertools import product

import numpy as np
import pandas as pd


def study(sizes, k, rng) -> pd.DataFrame:
    n = sum(sizes)
    table = pd.DataFrame(list(product(range(n), range(k))), columns=["subject", "freq"])
    group = np.repeat(np.arange(len(sizes)), sizes)
    values = rng.normal(size=(n, k)) * np.arange(1, k + 1) + rng.normal(size=(n, 1)) + group[:, None]
    return table.assign(y=values.ravel(), hand=np.array(["left", "right", "both"])[group][table["subject"]])
