"""Screens, foci and emissions of the time-reversal items, with their default (unverified) parameters."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.focusing.focusing import Emission
from tactometry.stimuli.time_reversal.focusing.sigma_delta import SigmaDelta
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33
from tactometry.stimuli.time_reversal.plate.plate import Plate
from tactometry.stimuli.time_reversal.screen.attenuation import TAU_S, Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import SIDE_M, DiscPatch, Patch

FOCUS: Final = (0.121, 0.093)
P1: Final = (0.205, 0.142)
ELSEWHERE: Final = (P1, (0.06, 0.05), (0.24, 0.06), (0.07, 0.15), (0.18, 0.11))
FOCI: Final = [(x, y) for y in (0.045, 0.105, 0.165) for x in (0.05, 0.1, 0.15, 0.2, 0.25)]
RIG_BAND: Final = Emission(Band(200.0, 25e3, 200.0), 2 * TAU_S, 100e3)
UNFILTERED: Final = Emission(Band(200.0, 60e3, 200.0), 2 * TAU_S, 250e3)
FILTERED: Final = Emission(Band(20e3, 60e3, 200.0), 2 * TAU_S, 250e3)
FOUR: Final[Mapping[str, Emission]] = {
    "1 bit": UNFILTERED,
    "1 bit, filtered": FILTERED,
    "SDM": Emission(UNFILTERED.band, 2 * TAU_S, 1e6, quantiser=SigmaDelta(2)),
    "SDM, filtered": Emission(FILTERED.band, 2 * TAU_S, 1e6, quantiser=SigmaDelta(2)),
}
N_COLUMNS, STEP_M, EDGE_M = 16, 18e-3, 13.5e-3


def thick_plate(thickness_m: float) -> Plate:
    """Return an A4 sheet of Borofloat with supported edges."""
    return BOROFLOAT_33.plate(0.297, 0.21, thickness_m, "SSSS")


def rig(diameter_m: float, thickness_m: float = 2e-3) -> Screen:
    """Return the rig of chapter 3: discs along two sides of thick glass.

    Their positions are an unverified default.
    """
    discs = tuple(DiscPatch(float(x), y, diameter_m) for y in (0.025, 0.185) for x in np.linspace(0.03, 0.267, 4))
    return Screen(thick_plate(thickness_m), discs, Attenuation(TAU_S))


def one_sided() -> Screen:
    """Return 32 square patches in two rows along one long side.

    Positions are unverified defaults.
    """
    places = [(EDGE_M + STEP_M * column, EDGE_M + STEP_M * row) for row in range(2) for column in range(N_COLUMNS)]
    return Screen(A4_SCREEN, tuple(Patch(x, y, SIDE_M, SIDE_M) for x, y in places), Attenuation(TAU_S))
