"""Finding 4: trains at 200 Hz under a sinc please most, a single focus least."""

from collections.abc import Iterator, Mapping
from statistics import fmean

from tactometry.observers.responses import COMFORT_DB, COMFORT_RANGE_DB, liking
from tactometry.stimuli.time_reversal.focusing.pattern import HIGH_HZ, LOW_HZ, PATTERNS

from ...study.cells import WiredCell
from ..reproduction import Number, Reproduction
from .studies import contact_of, experiment

STUDY = "time-reversal-patterns"
SAME_DB = 1.0
"""A difference of less is no order."""
LEAST = "P0"
BEST = ("200 Hz", "sinc")
"""The frequency and the envelope that please most: stated of each by itself."""


def numbers() -> Iterator[Number]:
    felt_db = levels_db()
    liked = {name: liking(level_db) for name, level_db in felt_db.items()}
    order = sorted(liked, key=lambda name: -liked[name])
    spread_db = max(felt_db.values()) - min(felt_db.values())
    for name, level_db in felt_db.items():
        yield Number("sensation level", words(name), level_db, "dB", "calibrated")
        yield Number("over the single focus", words(name), level_db - felt_db[LEAST], "dB", "derived")
        yield Number("pleasantness", words(name), liked[name], "of 1", "assumed")
        yield Number("place", words(name), order.index(name) + 1.0, "", "assumed", *_statement(name, order, spread_db))

    yield from _by_factor(liked, spread_db)


def _by_factor(liked: Mapping[str, float], spread_db: float) -> Iterator[Number]:
    """Means over the trains of one frequency, or of one envelope."""
    trains = {name: words(name).split(", ")[1:] for name in liked if name != LEAST}
    for column in range(2):
        values = dict.fromkeys(train[column] for train in trains.values())
        means = {value: fmean(liked[name] for name in trains if trains[name][column] == value) for value in values}
        most = max(means, key=lambda value: means[value])
        for value, mean in means.items():
            compared = ("pleases most", spread_db >= SAME_DB and value == most) if value in BEST else ()
            yield Number("mean pleasantness", f"trains, {value}", mean, "of 1", "assumed", *compared)


def levels_db() -> dict[str, float]:
    """What each pattern of the built-in study is felt as, at its level and touch."""
    return {str(cell.condition.factors["pattern"]): _felt_db(cell) for cell in experiment(STUDY).cells.values()}


def _felt_db(cell: WiredCell) -> float:
    """At the highest level that the study asks for, which is its only one."""
    _, level = cell.procedure.rule.bounds
    return cell.sensation.sensation_db(cell.stimulus.at(level), contact_of(cell))


def _statement(name: str, order: list[str], spread_db: float) -> tuple[str, bool | None]:
    """Of patterns that are felt alike no place counts."""
    return ("last: pleases least", spread_db >= SAME_DB and order[-1] == name) if name == LEAST else ("", None)


def words(name: str) -> str:
    pattern = PATTERNS[name]
    if pattern.n_foci == 1:
        return f"{name}, a single focus"
    rate_hz = LOW_HZ if pattern.repetition_hz == LOW_HZ else HIGH_HZ
    return f"{name}, {rate_hz:g} Hz, {type(pattern.envelope).__name__.lower()}"


FINDING = Reproduction(
    title="200 Hz trains under a sinc envelope please most, single foci least",
    stated="200 Hz and a cardinal sine are the most pleasant; a single focus is judged brief and not pleasant "
    "(page 4); seven patterns P0 to P6 (pages 13 and 14). Scores, and the other frequency and envelopes, are not in "
    "our sources; earlier work names 200 to 500 Hz (page 36).",
    assumes="The patterns, level and touch of the built-in study time-reversal-patterns; 500 "
    "Hz, a rectangle and an exponential beside 200 Hz and a sinc are unverified defaults. Pleasantness is an "
    f"inverted U of the sensation level L, 1 - 2 min(|L - {COMFORT_DB:g} dB| / {COMFORT_RANGE_DB:g} dB, 1) (the rating "
    "model of simulated participants, unverified). A spread of the levels below 1 dB is no order.",
    numbers=numbers,
    outcome="This rating model knows one thing of a pattern, how strongly it is felt, and has its optimum put in. "
    "A single focus is last because it is the weakest and all are below the optimum, and 200 Hz comes before 500 Hz "
    "under each envelope because it is felt more strongly; above the optimum both orders would turn round. A rectangle "
    "comes before a sinc, as it has the more energy: the model holds nothing that makes an envelope itself pleasant, "
    "no brevity, no rhythm, no likeness to a click.",
)
