"""Checks of tests and intervals for questionnaire scores."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

import numpy as np
import pandas as pd

from tactometry.analysis.attrakdiff.scoring import THESIS, against_reference, frequency_by_envelope, scores, summary
from tactometry.observers.raters import Rater, Raters
from tactometry.protocols.tasks.rating import pages
from tactometry.questionnaire import load
from tactometry.rigs.simulated import value_of

from ...study.session_plan import stream
from ...study.task_table import dimensions_of
from ..check import Simulate

FORM: Final = load("attrakdiff")
DIMENSION: Final = "PQ"
PATTERNS: Final = ("P0", *THESIS)
N_PARTICIPANTS: Final = 12
ATTITUDE: Final = 0.2
"""Attitude to patterns with the high frequency, from -1 to 1 (0.6 points on the scale before clipping)."""
RATERS: Final[Mapping[float, Raters]] = {
    effect: Raters(
        noise=0.35,
        liking=0.0,
        effects={
            "pattern": {name: {DIMENSION: effect} for name, (frequency, _) in THESIS.items() if frequency == "high"}
        },
    )
    for effect in (0.0, ATTITUDE)
}
"""Raters of the study time-reversal-patterns, with only this effect."""


def study(effect: float, seed: int) -> pd.DataFrame:
    """Simulate a study, with a row for each answer (a whole number)."""
    rows = []
    for code in (f"P{number:02d}" for number in range(N_PARTICIPANTS)):
        rater = Rater(
            RATERS[effect], partial(stream, seed, code), dimensions_of([FORM]), lambda met: {"pattern": str(met)}
        )
        for pattern in PATTERNS:
            noise = stream(seed, code, pattern)
            for page in pages(FORM, FORM.items):
                places = rater.answers(page, pattern, 0.0, noise)
                answers = zip(page.questions, places, strict=True)
                rows += [(code, pattern, FORM.name, question.item, value_of(at, page)) for question, at in answers]
    return pd.DataFrame(rows, columns=["participant", "pattern", "procedure", "item", "response"])


def scored(effect: float, rng: np.random.Generator) -> pd.DataFrame:
    return scores(study(effect, int(rng.integers(2**62))), within=["pattern"])


def _crossed(source: str) -> Callable[[pd.DataFrame], float]:
    def p(table: pd.DataFrame) -> float:
        result = frequency_by_envelope(table)
        rows = result[(result["dimension"] == DIMENSION) & (result["Source"] == source)]
        return float(rows["p_CM_corr"].iloc[0])

    return p


def _against(table: pd.DataFrame) -> pd.DataFrame:
    result = against_reference(table)
    return result[result["dimension"] == DIMENSION]


TESTED: Final[Mapping[str, Callable[[pd.DataFrame], float]]] = {
    "frequency": _crossed("frequency"),
    "envelope": _crossed("envelope"),
    "frequency * envelope": _crossed("frequency * envelope"),
    "against P0, Holm: any of six": lambda table: _against(table)["p_corr"].min(),
}


def false_alarms(n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Test simulated studies without an effect, and others with an effect."""
    rows = []
    for effect in RATERS:
        for table in (scored(effect, rng) for _ in range(n_sets)):
            rows += [(effect, test, float(p(table))) for test, p in TESTED.items()]
    return pd.DataFrame(rows, columns=["effect", "test", "p"])


def effects(n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Estimate means and differences of patterns with equal true ratings."""
    rows = []
    for table in (scored(0.0, rng) for _ in range(n_sets)):
        pair = _against(table).iloc[0]
        means = summary(table)
        mean = means[(means["dimension"] == DIMENSION) & (means["pattern"] == PATTERNS[0])].iloc[0]
        rows.append(("mean", *mean[["mean", "mean_low", "mean_high"]]))
        rows.append(("difference to P0", *pair[["difference", "difference_low", "difference_high"]]))
    return pd.DataFrame(rows, columns=["method", "estimate", "low", "high"]).assign(truth=0.0)


PEOPLE: Final = f"""\
{N_PARTICIPANTS} simulated participants ([observer.raters](../reference/people.md)) rate seven patterns with
AttrakDiff's 28 word pairs, in whole steps, as in the study `time-reversal-patterns`. Pragmatic quality is tested."""
FALSE_ALARMS: Final[Mapping[str, Simulate]] = {"patterns": false_alarms}
EFFECTS: Final[Mapping[str, Simulate]] = {"patterns": effects}
