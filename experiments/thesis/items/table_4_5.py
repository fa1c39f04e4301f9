"""Table 4.5: sound of the four driving signals."""

from ..reproduction import Number, Reproduction
from .four_signals import ASSUMES, measured


def numbers() -> list[Number]:
    levels_db = {name: signal.sound_dba for name, signal in measured().items()}
    first = next(iter(levels_db.values()))
    quieter = "filtering the audible frequencies reduces the sound"
    return [
        number
        for name, level_db in levels_db.items()
        for number in (
            Number("A-weighted level", name, level_db, "dBA", "calibrated"),
            Number(
                "re one bit unfiltered", name, level_db - first, "dB", "derived", *_stated(name, levels_db, quieter)
            ),
        )
    ]


def _stated(name: str, levels_db: dict[str, float], said: str) -> tuple[str, bool | None]:
    bare, comma, _ = name.partition(", filtered")
    return (said, levels_db[name] < levels_db[bare]) if comma else ("", None)


TABLE = Reproduction(
    title="Noise emission of the driving signals",
    stated="That levels were measured in dBA (page 16), and that filtering the audible frequencies reduces the "
    "sound (page 3); the values, distance and room are not in our sources.",
    assumes=f"{ASSUMES} Sound radiated by a baffled plate into a half space, at 0.3 m, averaged over the drive "
    "and five tau: a model for ranking, whose absolute level goes with the calibrated amplitude.",
    numbers=numbers,
)
