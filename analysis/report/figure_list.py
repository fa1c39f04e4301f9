"""Which figures a report has, in order, each with its place in the page and the table that holds its numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import pandas as pd

from ..anova.group_means import HIGH, LOW, bounds_of
from ..attrakdiff.patterns import THESIS
from ..figures import attrakdiff, group, growth, loss, participants
from ..figures.style import Drawing
from ..outcomes.findings import FORCE, Outcome
from ..outcomes.hierarchical_outcome import HierarchicalOutcome
from ..outcomes.ratings import REFERENCE, Ratings
from ..result import Analysis
from ..tasks.cells import Estimate
from ..tasks.kinds import CURVES
from ..tasks.magnitude import DEPENDENT as EXPONENT, GROWTH, TASK as MAGNITUDE
from ..tasks.rates import MAX_LEVELS
from .captions import figure_text, means_of

NAMES = {
    "threshold": "Detection threshold",
    "pse": "Point of subjective equality",
    "jnd": "Just noticeable difference",
    "setting": "Setting by adjustment",
    "exponent": "Exponent of magnitude estimates",
}
TRACKS = {
    "staircase": "staircase",
    "weighted_staircase": "weighted staircase",
    "method_of_limits": "method of limits",
    "quest": "QUEST",
    "quest_plus": "QUEST+",
    "psi": "psi method",
}
"""What a filled dot of a track means."""
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
    drawn = [_outcome_figure(found, outcome) for outcome in found.outcomes]
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
    for task in sorted({estimate.cell.task for estimate in shown} & set(CURVES)):
        drawn += _rate_figures(found, task)
    for code in sorted({estimate.cell.participant for estimate in shown}):
        own = [estimate for estimate in shown if estimate.cell.participant == code]
        drawn += [_curves(own, found, code), *_tracks(found, code)]
    return drawn


def _outcome_figure(found: Analysis, outcome: Outcome) -> Figure:
    name, unit = NAMES[outcome.dependent], outcome.unit(found.unit)
    drawing = group.threshold_figure(
        outcome.group,
        found.trials.factors,
        label=f"{name} ({unit})" if unit else name,
        individuals=bounds_of(outcome.estimates, outcome.dependent),
        dependent=outcome.dependent,
    )
    dots = f"faint dots are participants{_triangles(outcome)}"
    text = f"{name}: {figure_text(outcome.group, dots)}."
    stem = found.stem(outcome)
    return Figure(stem, drawing, text, f"group_{stem}", Place.OUTCOME, f"{outcome.task} {outcome.dependent}")


def _triangles(outcome: Outcome) -> str:
    held = bounds_of(outcome.estimates, outcome.dependent)
    return ", open triangles bounds" if held[[LOW, HIGH]].notna().any(axis=None) else ""


def _growth_figure(found: Analysis) -> Figure:
    drawing = growth.growth_figure(found.tables[GROWTH], found.trials.factors, unit=found.unit)
    text = "Numbers given to each level: geometric means over participants after modulus equalisation."
    return Figure(GROWTH, drawing, text, GROWTH, Place.OUTCOME, f"{MAGNITUDE} {EXPONENT}")


def _loss_figure(found: Analysis) -> Figure:
    own = found.tables["loss"]
    over = "participants" if own["n"].max() > 1 else "readings of one participant"
    bars = "; bars are 95 % t-intervals" if own["mean_low"].notna().any() else ""
    text = f"Loss of amplitude: means over {over}{bars}."
    return Figure("loss", loss.loss_figure(own, found.trials.factors), text, "loss", Place.LOSS)


def _together_figure(found: Analysis, each: HierarchicalOutcome) -> Figure:
    name = NAMES[CURVES[each.task].dependents[0]]
    factors = [factor for factor in found.trials.factors if factor in each.conditions.columns]
    columns = {"threshold": "mean", "interval_low": "mean_low", "interval_high": "mean_high"}
    drawing = group.threshold_figure(
        each.conditions.rename(columns=columns),
        factors,
        label=f"{name} ({found.unit})" if found.unit else name,
        individuals=each.participants,
        dependent="threshold",
    )
    bars = " with 95 % intervals" if each.conditions["interval_low"].notna().any() else ""
    text = f"{name}: the hierarchical model's means{bars}; faint dots are participants, drawn to the group."
    stem = f"hierarchical_{each.task}"
    return Figure(stem, drawing, text, stem, Place.TOGETHER, each.task)


def _force_figure(found: Analysis) -> Figure:
    factors = found.trials.factors
    own = found.tables["force_participants"]
    stated = [] if found.study.force_n is None else [found.study.force_n]
    targets = sorted(set(own[FORCE].astype(float))) if FORCE in factors else stated
    drawing = group.threshold_figure(
        found.tables["force"],
        factors,
        label="Mean applied force (N)",
        individuals=own,
        dependent="force_mean_n",
        targets=targets,
        from_zero=True,
    )
    dashed = f"; dashed: {'the target' if len(targets) == 1 else 'targets'}" if targets else ""
    text = f"Mean applied force: {figure_text(found.tables['force'], 'faint dots are participants')}{dashed}."
    return Figure("force", drawing, text, "force", Place.FORCE)


def _form_figures(form: Ratings) -> list[Figure]:
    stem = form.name.replace("-", "_")
    names = list(dict.fromkeys(form.summary["condition"]))
    order = list(form.form.dimensions)
    low, high = form.form.score_low, form.form.score_high

    def figure(part: str, drawing: Drawing, caption: str, table: str) -> Figure:
        return Figure(f"{stem}_{part}", drawing, caption, f"{stem}_{table}", Place.FORM, form.name)

    scores = attrakdiff.scores_figure(form.summary, names[:MOST_LINES], order, low, high)
    found = [figure("scores", scores, f"Scores: {figure_text(form.summary)}.", "summary")]
    if form.portfolio is not None:
        bars = " with 95 % confidence rectangles" if form.portfolio["PQ_low"].notna().any() else ""
        text = f"Portfolio: {means_of(form.summary)}{bars}."
        found.append(figure("portfolio", attrakdiff.portfolio_figure(form.portfolio), text, "portfolio"))
    if form.crossed is not None:
        drawing = attrakdiff.crossed_figure(form.summary, THESIS, order, REFERENCE, (low, high))
        shaded = " with its t-interval between participants" if form.summary["mean_low"].notna().any() else ""
        band = f"dashed{shaded}: {REFERENCE}"
        text = f"Frequency by envelope: {figure_text(form.summary)}; {band}."
        found.append(figure("frequency_by_envelope", drawing, text, "summary"))
    for part, chosen in _profiles(form, names):
        drawing = attrakdiff.profile_figure(form.profile, chosen, low, high)
        of = f" of {', '.join(chosen)}" if len(names) > 1 else ""
        text = f"{_items(form)}: {means_of(form.summary)}{of}."
        found.append(figure(part, drawing, text, "word_pairs"))
    return found + ([] if form.grouped is None else _grouped_figures(form, form.grouped, stem))


def _items(form: Ratings) -> str:
    """Whether the items of a questionnaire are pairs of words or sentences."""
    return "Word pairs" if form.profile["negative"].astype(bool).any() else "Items"


def _grouped_figures(form: Ratings, grouped: pd.DataFrame, stem: str) -> list[Figure]:
    """The thesis's comparisons of frequencies and of envelopes, each with the single focus."""
    found = []
    for of, part in grouped.groupby("of", sort=False):
        names = list(dict.fromkeys(part["condition"]))
        drawing = attrakdiff.profile_figure(part, names, form.form.score_low, form.form.score_high)
        text = f"Word pairs by {of}: {means_of(form.summary)}, over patterns; {REFERENCE} beside them."
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
    kind = CURVES[task].rate_label
    of = ("task", task)
    counts = found.tables["counts"]
    own = counts[counts["task"] == task]
    is_one = own["participant"].nunique() == 1
    drawing = group.rate_figure(rates, factors, unit=found.unit)
    classes = f"; levels in {MAX_LEVELS} classes, each at its mean" if own["level"].nunique() > MAX_LEVELS else ""
    text = f"{kind} against level, {'one participant' if is_one else 'all participants together'}{classes}."
    drawn = [Figure(f"rates_{task}", drawing, text, "rates", Place.RATES, of=of)]
    if factors and not _is_tracked(found, task):
        text = f"{kind} over all levels, {'one participant' if is_one else 'mean over participants'}."
        drawing = group.mean_rate_figure(means, factors)
        drawn.append(Figure(f"mean_rates_{task}", drawing, text, "mean_rates", Place.RATES, of=of))
    return drawn


def _is_tracked(found: Analysis, task: str) -> bool:
    """Whether levels followed the answers: the rate over all of them then tells of the procedure alone."""
    return "tracks" in found.tables and task in set(found.tables["tracks"]["task"])


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
    kinds = ", ".join(TRACKS.get(name, name) for name in sorted(set(rows["procedure"])))
    text = f"{code}: tracks ({kinds}); filled: {_filled(rows)}, open: not; catch trials are left out."
    return [
        Figure(f"{code}_tracks", drawing, text, "tracks", Place.PARTICIPANTS, f"{code}: tracks", ("participant", code))
    ]


def _filled(rows: pd.DataFrame) -> str:
    return " or ".join(CURVES[task].success for task in sorted(set(rows["task"])))
