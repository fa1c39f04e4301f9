"""Which figures a report has, in order, each with its place in the page and the table that holds its numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import pandas as pd

from tactometry.analysis.cells import Estimate
from tactometry.analysis.figures import attrakdiff, group, growth, loss, participants
from tactometry.analysis.figures.axes import RATE_LABEL
from tactometry.analysis.findings import FORCE, Outcome
from tactometry.analysis.group import HIGH, LOW, MODEL, bounds_of
from tactometry.analysis.magnitude import DEPENDENT as EXPONENT
from tactometry.analysis.magnitude import GROWTH
from tactometry.analysis.magnitude import TASK as MAGNITUDE
from tactometry.analysis.patterns import THESIS
from tactometry.analysis.pipeline import Analysis
from tactometry.analysis.ratings import REFERENCE, Ratings
from tactometry.analysis.style import Drawing
from tactometry.analysis.together import Together

NAMES = {
    "threshold": "Detection threshold",
    "pse": "Point of subjective equality",
    "jnd": "Just noticeable difference",
    "setting": "Setting by adjustment",
    "exponent": "Exponent of magnitude estimates",
}
MOST_LINES = 7
"""A figure of word pairs shows no more conditions than there are colours."""


class Place(StrEnum):
    """The section of the page."""

    OUTCOME = "outcome"
    TOGETHER = "together"
    FORM = "form"
    LOSS = "loss"
    FORCE = "force"
    RATES = "rates"
    PARTICIPANTS = "participants"


@dataclass(frozen=True)
class Figure:
    """A drawing with its file name, caption, and the table of numbers (of them those rows that `of` holds); `about`
    is the outcome, questionnaire or participant it belongs to."""

    name: str
    drawing: Drawing
    caption: str
    table: str
    place: Place
    about: str = ""
    of: tuple[str, str] | None = None

    def rows(self, table: pd.DataFrame) -> pd.DataFrame:
        """The rows of its table that it draws."""
        return table if self.of is None else table[table[self.of[0]] == self.of[1]]


def figures_of(found: Analysis) -> list[Figure]:
    """Every figure of the report."""
    several = len({outcome.task for outcome in found.outcomes}) > 1
    drawn = [_outcome_figure(found, outcome, several=several) for outcome in found.outcomes]
    drawn += [_together_figure(found, each) for each in found.together if each.fit is not None]
    for form in found.forms:
        drawn += _form_figures(form)
    if GROWTH in found.tables:
        drawn.append(_growth_figure(found))
    if "loss" in found.tables:
        drawn.append(_loss_figure(found))
    if "force" in found.tables:
        drawn.append(_force_figure(found))
    shown = [estimate for estimate in found.estimates if estimate.cell.levels]  # the others are catch trials alone
    for task in sorted({estimate.cell.task for estimate in shown} & set(RATE_LABEL)):
        drawn += _rate_figures(found, task)
    for code in sorted({estimate.cell.participant for estimate in shown}):
        own = [estimate for estimate in shown if estimate.cell.participant == code]
        drawn += [_curves(own, found, code), *_tracks(found, code)]
    return drawn


def _outcome_figure(found: Analysis, outcome: Outcome, *, several: bool) -> Figure:
    name, unit = NAMES[outcome.dependent], outcome.unit(found.unit)
    drawing = group.threshold_figure(
        outcome.group,
        found.trials.factors,
        label=f"{name} ({unit})" if unit else name,
        individuals=bounds_of(outcome.estimates, outcome.dependent),
        dependent=outcome.dependent,
    )
    text = f"{name}: means over participants{_bars(outcome.group)}; faint dots are participants{_triangles(outcome)}."
    stem = f"{outcome.task}_{outcome.dependent}" if several else outcome.dependent
    return Figure(stem, drawing, text, f"group_{stem}", Place.OUTCOME, f"{outcome.task} {outcome.dependent}")


def _bars(means: pd.DataFrame) -> str:
    """What the bars of a figure are: what was drawn, no more."""
    drawn = [bool(means[name].notna().any()) for name in ("within_low", "mean_low")]
    kinds = ["bars are 95 % intervals within participants (Cousineau-Morey)"] * drawn[0]
    kinds += [f"{'thin lines' if drawn[0] else 'bars'} are 95 % t-intervals between participants"] * drawn[1]
    told = "; ".join(["", *kinds])
    is_model = "method" in means.columns and (means["method"] == MODEL).any()
    return told + (", of the censored model where a value is a bound" if is_model else "")


def _triangles(outcome: Outcome) -> str:
    held = bounds_of(outcome.estimates, outcome.dependent)
    return ", open triangles bounds" if held[[LOW, HIGH]].notna().any(axis=None) else ""


def _growth_figure(found: Analysis) -> Figure:
    drawing = growth.growth_figure(found.tables[GROWTH], found.trials.factors, unit=found.unit)
    text = "Numbers given to each level: geometric means over participants after modulus equalisation."
    return Figure(GROWTH, drawing, text, GROWTH, Place.OUTCOME, f"{MAGNITUDE} {EXPONENT}")


def _loss_figure(found: Analysis) -> Figure:
    own = found.tables["loss"]
    over = "participants" if own["n"].max() > 1 else "readings"
    text = f"Loss of amplitude: means with 95 % t-intervals over {over}."
    return Figure("loss", loss.loss_figure(own, found.trials.factors), text, "loss", Place.LOSS)


def _together_figure(found: Analysis, each: Together) -> Figure:
    name = NAMES["pse" if each.task == "comparison" else "threshold"]
    factors = [factor for factor in found.trials.factors if factor in each.conditions.columns]
    columns = {"threshold": "mean", "interval_low": "mean_low", "interval_high": "mean_high"}
    drawing = group.threshold_figure(
        each.conditions.rename(columns=columns),
        factors,
        label=f"{name} ({found.unit})" if found.unit else name,
        individuals=each.participants,
        dependent="threshold",
    )
    text = (
        f"{name}: the hierarchical model's means with 95 % intervals; faint dots are participants, drawn to the group."
    )
    stem = f"hierarchical_{each.task}"
    return Figure(stem, drawing, text, stem, Place.TOGETHER, each.task)


def _force_figure(found: Analysis) -> Figure:
    factors = found.trials.factors
    own = found.tables["force_participants"]
    targets = sorted(set(own[FORCE].astype(float))) if FORCE in factors else []
    drawing = group.threshold_figure(
        found.tables["force"],
        factors,
        label="Mean applied force (N)",
        individuals=own,
        dependent="force_mean_n",
        targets=targets,
    )
    dashed = "; dashed: targets" if targets else ""
    text = f"Mean applied force: means over participants with 95 % t-intervals; faint dots are participants{dashed}."
    return Figure("force", drawing, text, "force", Place.FORCE)


def _form_figures(form: Ratings) -> list[Figure]:
    stem = form.name.replace("-", "_")
    names = list(dict.fromkeys(form.summary["condition"]))
    order = list(form.form.dimensions)
    low, high = form.form.score_low, form.form.score_high

    def figure(part: str, drawing: Drawing, caption: str, table: str) -> Figure:
        return Figure(f"{stem}_{part}", drawing, caption, f"{stem}_{table}", Place.FORM, form.name)

    scores = attrakdiff.scores_figure(form.summary, names[:MOST_LINES], order, low, high)
    found = [figure("scores", scores, f"Scores: means over participants{_bars(form.summary)}.", "summary")]
    if form.portfolio is not None:
        text = "Portfolio: means with 95 % confidence rectangles over participants."
        found.append(figure("portfolio", attrakdiff.portfolio_figure(form.portfolio), text, "portfolio"))
    if form.crossed is not None:
        drawing = attrakdiff.crossed_figure(form.summary, THESIS, order, REFERENCE, (low, high))
        band = f"dashed with its t-interval between participants: {REFERENCE}"
        text = f"Frequency by envelope: means over participants{_bars(form.summary)}; {band}."
        found.append(figure("frequency_by_envelope", drawing, text, "summary"))
    for part, chosen in _profiles(form, names):
        drawing = attrakdiff.profile_figure(form.profile, chosen, low, high)
        text = f"Word pairs: means over participants of {', '.join(chosen)}."
        found.append(figure(part, drawing, text, "word_pairs"))
    return found + ([] if form.grouped is None else _grouped_figures(form, form.grouped, stem))


def _grouped_figures(form: Ratings, grouped: pd.DataFrame, stem: str) -> list[Figure]:
    """The thesis's comparisons of frequencies and of envelopes, each with the single focus."""
    found = []
    for of, part in grouped.groupby("of", sort=False):
        names = list(dict.fromkeys(part["condition"]))
        drawing = attrakdiff.profile_figure(part, names, form.form.score_low, form.form.score_high)
        text = f"Word pairs by {of}: means over participants and patterns; {REFERENCE} beside them."
        table = f"{stem}_word_pairs_grouped"
        found.append(Figure(f"{stem}_word_pairs_by_{of}", drawing, text, table, Place.FORM, form.name, ("of", str(of))))
    return found


def _profiles(form: Ratings, names: Sequence[str]) -> list[tuple[str, list[str]]]:
    """The thesis's comparisons where its patterns were rated, else all conditions together."""
    if form.crossed is None:
        return [("word_pairs", list(names[:MOST_LINES]))]
    groups = {f: [p for p, (own, _) in THESIS.items() if own == f] for f, _ in THESIS.values()}
    start = [REFERENCE] if REFERENCE in names else []
    return [(f"word_pairs_{f}_frequency", [*start, *codes]) for f, codes in groups.items()]


def _rate_figures(found: Analysis, task: str) -> list[Figure]:
    factors = found.trials.factors
    rates, means = (table[table["task"] == task] for table in (found.tables["rates"], found.tables["mean_rates"]))
    kind = RATE_LABEL[task]
    of = ("task", task)
    drawing = group.rate_figure(rates, factors, unit=found.unit)
    text = f"{kind} against level, all participants together."
    drawn = [Figure(f"rates_{task}", drawing, text, "rates", Place.RATES, of=of)]
    if factors:
        text = f"{kind} over all levels, mean over participants."
        drawing = group.mean_rate_figure(means, factors)
        drawn.append(Figure(f"mean_rates_{task}", drawing, text, "mean_rates", Place.RATES, of=of))
    return drawn


def _curves(own: Sequence[Estimate], found: Analysis, code: str) -> Figure:
    drawing = participants.curve_figure(own, found.trials.factors, unit=found.unit)
    text = (
        f"{code}: rate at each level (dot size: trials) with Wilson's 95 % interval, fitted curve, and below it the "
        "threshold with its 95 % interval."
    )
    about = f"{code}: psychometric curves"
    return Figure(f"{code}_curves", drawing, text, "counts", Place.PARTICIPANTS, about, ("participant", code))


def _tracks(found: Analysis, code: str) -> list[Figure]:
    rows = found.tables.get("tracks", pd.DataFrame({"participant": []}))
    rows = rows[rows["participant"] == code]
    if rows.empty:
        return []
    drawing = participants.track_figure(rows, found.trials.factors, unit=found.unit)
    text = f"{code}: staircases; filled: yes or correct, open: not; catch trials are left out."
    return [
        Figure(f"{code}_tracks", drawing, text, "tracks", Place.PARTICIPANTS, f"{code}: tracks", ("participant", code))
    ]
