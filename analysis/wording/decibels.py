"""Levels in decibels as the amplitudes that they stand for."""

import pandas as pd

from .numbers import interval_text

RE = "dB re 1 "


def is_decibel(unit: str) -> bool:
    """
    >>> is_decibel("dB re 1 V"), is_decibel("dB"), is_decibel("V")
    (True, False, False)
    """
    return unit.startswith(RE)


def as_amplitudes(group: pd.DataFrame) -> pd.DataFrame:
    """A group table whose `text` tells amplitudes, 10^(level / 20): of a mean of levels the geometric mean. Where there
    is no mean the text stays.

    >>> as_amplitudes(pd.DataFrame({"mean": [20.0], "mean_low": [0.0], "mean_high": [40.0], "text": [""]}))["text"][0]
    '10.0 [1.0, 100.0]'
    """
    ends = [(10 ** (group[name].astype(float) / 20)).tolist() for name in ("mean", "mean_low", "mean_high")]
    texts = [
        text if pd.isna(row[0]) else interval_text(*row)
        for text, row in zip(group["text"], zip(*ends, strict=True), strict=True)
    ]
    return group.assign(text=texts)
