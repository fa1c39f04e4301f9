"""Table 2.1: where each receptor channel mediates detection."""

from collections.abc import Iterator

import numpy as np

from tactometry.stimuli.perception.channels import NP_I, NP_III, P, channel_thresholds_db

from ..reproduction import Number, Reproduction

STATED_HZ = {
    "Merkel (NP III)": (NP_III, 0.0, 3.0),
    "Meissner (NP I)": (NP_I, 20.0, 50.0),
    "Pacini (P)": (P, 50.0, 500.0),
}
BEST_HZ = 250.0
HALF_AN_OCTAVE = 0.5


def numbers() -> Iterator[Number]:
    f_hz = np.geomspace(0.4, 1000.0, 2001)
    thresholds_db = channel_thresholds_db(f_hz)
    lowest, felt = thresholds_db.argmin(axis=0), np.isfinite(thresholds_db.min(axis=0))
    for name, (row, from_hz, to_hz) in STATED_HZ.items():
        band_hz = f_hz[(lowest == row) & felt]
        yield _number("mediates from", name, band_hz[0], from_hz)
        yield _number("mediates to", name, band_hz[-1], to_hz)
        for end, at_hz in (("from", from_hz), ("to", to_hz)):
            if at_hz > 0:
                over_db = float(channel_thresholds_db(at_hz)[row, 0] - thresholds_db[row].min())
                yield Number(f"threshold where stated {end}, over its lowest", name, over_db, "dB", "assumed")
    best_hz = float(f_hz[thresholds_db[P].argmin()])
    yield _number("most sensitive at", "Pacini (P)", best_hz, BEST_HZ)


def _number(quantity: str, channel: str, found_hz: float, stated_hz: float) -> Number:
    """Agrees within half an octave; from 0 Hz on, if it begins below 1 Hz."""
    near = found_hz < 1 if stated_hz == 0 else abs(np.log2(found_hz / stated_hz)) <= HALF_AN_OCTAVE
    return Number(quantity, channel, float(found_hz), "Hz", "assumed", f"{stated_hz:g} Hz", bool(near))


TABLE = Reproduction(
    title="Characteristics of the mechanoreceptors",
    stated="Merkel 0-3 Hz, Ruffini 200-300 Hz, Meissner 20-50 Hz, Pacini 50-500 Hz (page 25), most sensitive "
    "near 250 Hz (page 32).",
    assumes="The thresholds of the channels (unverified defaults after Bolanowski et al. 1988). A channel "
    "mediates where its threshold is the lowest; a frequency agrees within half an octave. Ruffini endings have "
    "no channel here.",
    numbers=numbers,
    outcome="All is put in. What does not agree are ends that no threshold sets: from 3 to 20 Hz the stated ranges "
    "name no channel, while one always has the lowest threshold, and that of Pacini ends at 800 Hz, where the curve "
    "ends. The stated ends are no limits of sensitivity either: at them a channel is less sensitive than at its best "
    "by anything from nothing to 28 dB, so that no one rule gives them all.",
)
