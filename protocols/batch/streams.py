"""Random streams of places in nested loops: of study 3, participant 12, track 0."""

import numpy as np

from tactometry.arguments.require import whole

LARGEST_PLACE = 2**32 - 1
LARGEST_SEED = 2**128 - 1


def stream(seed: int, *place: int) -> np.random.Generator:
    """The stream of one place: no other place has it, however deep, and no order of work changes it.

    A number of a place is one word of the key, and the seed at most four, so that no two places make the same words.

    Raises
    ------
    InvalidParameter
        If a number is below 0, the seed above 2**128 - 1 or one of a place above 2**32 - 1.

    >>> float(stream(1, 0, 7).random()) == float(stream(1, 0, 7).random()) != float(stream(1, 7, 0).random())
    True
    """
    whole("stream", lowest=0, highest=LARGEST_SEED, seed=seed)
    for number in place:
        whole("stream", lowest=0, highest=LARGEST_PLACE, place=number)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=place))
