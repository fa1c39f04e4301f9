"""Random streams that depend on who, when and what for, never on what was drawn before."""

import zlib

import numpy as np


def stream(seed: int, *keys: str | int) -> np.random.Generator:
    """The generator of `seed` for this use: equal keys give equal streams, other keys independent ones.

    >>> stream(1, "P01", 1, "protocol").integers(1000) == stream(1, "P01", 1, "protocol").integers(1000)
    np.True_
    """
    words = tuple(key if isinstance(key, int) else zlib.crc32(key.encode()) for key in keys)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=words))
