"""A published within-participant design, and its long table."""

from itertools import product

import numpy as np
import pandas as pd

# Science 11.5: 8 participants; force 0.5 | 1 | 2 N, each at 60 120 240 480 Hz; dB re 1 V
PUBLISHED = """
30.40 26.65 22.90 25.30 30.75 25.25 22.00 24.50 30.15 25.15 22.40 24.80
35.65 30.65 27.90 29.05 34.25 29.75 27.50 28.75 34.15 27.90 26.15 27.30
32.65 28.65 24.65 29.05 34.00 28.25 24.75 27.00 32.15 26.90 23.90 26.05
31.40 28.40 25.40 26.30 31.00 26.25 23.75 27.00 31.90 25.40 23.40 24.30
35.90 31.65 27.40 31.55 36.00 30.00 28.50 30.50 35.15 29.65 26.40 28.30
33.90 28.40 25.15 28.05 34.50 29.50 24.50 27.50 31.90 27.40 25.15 25.80
31.90 27.40 25.15 26.80 33.00 26.75 25.00 26.75 30.90 27.40 23.90 25.55
31.65 28.15 24.65 27.30 31.00 28.00 25.00 25.50 31.65 26.90 24.40 24.80
"""

WITHIN = ["force", "freq"]


def long_table(values: np.ndarray, forces=(0.5, 1, 2), frequencies=(60, 120, 240, 480)) -> pd.DataFrame:
    names = [f"P{n + 1}" for n in range(len(values))]
    keys = list(product(names, forces, frequencies))
    return pd.DataFrame(keys, columns=["subject", *WITHIN]).assign(y=values.ravel())
