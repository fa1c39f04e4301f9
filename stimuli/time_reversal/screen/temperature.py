"""Temperature: a warmer plate is softer, its frequencies fall, and a drive learnt cold is out of tune."""

from dataclasses import replace
from typing import Final

from tactometry.arguments.checked import checked
from tactometry.arguments.require import within

from .screen import Screen

FREQUENCY_SHIFT_PER_K: Final = -5e-5
"""Relative shift of the modal frequencies of borosilicate glass per kelvin; unverified default."""

MOST_SHIFT: Final = 0.1


@checked
def warmed(screen: Screen, kelvin: float, shift_per_k: float = FREQUENCY_SHIFT_PER_K) -> Screen:
    """The screen some kelvin warmer: Young's modulus by the square of the shift of the frequencies.

    Raises
    ------
    InvalidParameter
        If the frequencies shift by more than a tenth, where no glass goes on in proportion.

    >>> from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE
    >>> warm = warmed(A4_PROTOTYPE, 20.0)
    >>> round(warm.plate.wave_constant_m2_per_s / A4_PROTOTYPE.plate.wave_constant_m2_per_s, 6)
    0.999
    """
    within("warmed", -MOST_SHIFT, MOST_SHIFT, shift_of_frequencies=shift_per_k * kelvin)
    factor = (1 + shift_per_k * kelvin) ** 2
    return replace(screen, plate=replace(screen.plate, youngs_modulus_pa=screen.plate.youngs_modulus_pa * factor))
