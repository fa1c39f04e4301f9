"""Table 6.3: perception thresholds of electrovibration by frequency and force."""

from collections.abc import Iterator
from functools import lru_cache

from ..reproduction import Number, Reproduction
from .studies import contact_of, experiment, threshold_of

STUDY = "electrovibration-threshold"


@lru_cache(maxsize=1)
def thresholds_db() -> dict[float, dict[float, float]]:
    """Thresholds (dB re 1 V peak) by force (N) and frequency (Hz), as the median participant has them."""
    by_force: dict[float, dict[float, float]] = {}
    for cell in experiment(STUDY).cells.values():
        by_frequency = by_force.setdefault(contact_of(cell).force_n, {})
        by_frequency[float(cell.condition.factors["frequency_hz"])] = threshold_of(cell)
    return by_force


def _thresholds() -> Iterator[Number]:
    table = thresholds_db()
    first_n = min(table)
    for force_n, row in table.items():
        for frequency_hz, level_db in row.items():
            at = f"{frequency_hz:g} Hz"
            yield Number(f"threshold at {force_n:g} N", at, level_db, "dB re 1 V", "derived")
            if force_n != first_n:
                change_db = level_db - table[first_n][frequency_hz]
                yield Number(f"from {first_n:g} to {force_n:g} N", at, change_db, "dB", "derived")


TABLE_6_3 = Reproduction(
    title="Mean perception threshold by frequency and force",
    stated="That thresholds are in dB re 1 V peak (page 16) for three forces (page 14) and lowest at 240 Hz (page 4); "
    "the values, the other frequencies and the forces are not in our sources: finding-3.",
    assumes="The stimuli, touches and model of the built-in study electrovibration-threshold (frequencies and "
    "forces are unverified defaults): the force of a square-root carrier vibrates at the frequency of its "
    "envelope. No constant is set to a threshold of voltage; all levels rest on unverified defaults: the law of force, "
    "friction, the mobility of the skin and its displacement at threshold.",
    numbers=_thresholds,
)
