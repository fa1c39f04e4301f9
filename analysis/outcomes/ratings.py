"""Questionnaires of a data set: scores, tables and comparisons."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from tactometry.questionnaire import ChoiceForm, Questionnaire
from tactometry.trials.tasks import FORM_TASK

from ..attrakdiff.scoring import (
    THESIS,
    against_reference,
    consistency,
    frequency_by_envelope,
    grouped_profile,
    item_scores,
    portfolio,
    scores,
    summary,
    word_pairs,
)
from ..reading.origin import choices_of, forms_of
from ..reading.trials import Trials, asked_rows
from ..wording import condition_name, decimals_of, interval_text
from .findings import Outcome, Primary
from .outcome import outcome

PATTERN, REFERENCE = "pattern", "P0"


@dataclass(frozen=True)
class Ratings:
    """Results of one questionnaire.

    `scores` are by participant and condition, `summary` is over participants, `profile` is by item. `portfolio` is set
    if the questionnaire has pragmatic and hedonic quality. If the thesis's patterns were rated, its comparisons
    (`crossed`, `against`) and the `grouped` profile are set, otherwise an outcome for each dimension.
    """

    form: Questionnaire
    factors: tuple[str, ...]
    scores: pd.DataFrame
    summary: pd.DataFrame
    profile: pd.DataFrame
    consistency: pd.DataFrame
    portfolio: pd.DataFrame | None
    crossed: pd.DataFrame | None
    against: pd.DataFrame | None
    grouped: pd.DataFrame | None = None
    outcomes: Mapping[str, Outcome] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return self.form.name

    @property
    def stem(self) -> str:
        """Beginning of the file names of the tables."""
        return self.name.replace("-", "_")

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return all tables by file name."""
        stem = self.stem
        tables = {
            f"{stem}_scores": self.scores,
            f"{stem}_summary": self.summary,
            f"{stem}_word_pairs": self.profile,
            f"{stem}_consistency": self.consistency,
            f"{stem}_word_pairs_grouped": self.grouped,
            f"{stem}_portfolio": self.portfolio,
            f"{stem}_frequency_by_envelope": self.crossed,
            f"{stem}_against_{REFERENCE}": self.against,
        }
        known = {name: table for name, table in tables.items() if table is not None}
        # Effects and comparisons of all dimensions share a table.
        by_file: dict[str, list[pd.DataFrame]] = {}
        for dimension, one in self.outcomes.items():
            for name, table in one.tables(stem).items():
                if not name.startswith(("group_", "cross_")):  # the summary already contains the means
                    of_dimension = table.copy()  # do not modify the table of the outcome
                    of_dimension.insert(0, "dimension", dimension)
                    by_file.setdefault(f"{stem}_{name.replace(f'_{stem}', '', 1)}", []).append(of_dimension)
        return known | {name: pd.concat(tables, ignore_index=True) for name, tables in by_file.items()}

    @property
    def tests_effects(self) -> bool:
        """Return True if any F test was computed."""
        return self.crossed is not None or any(one.primary is not None for one in self.outcomes.values())

    @property
    def notes(self) -> list[str]:
        """Notes of the outcomes, each listed once with its dimensions."""
        dimensions_of: dict[str, list[str]] = {}
        for dimension, one in self.outcomes.items():
            for note in one.notes:
                dimensions_of.setdefault(note, []).append(dimension)
        notes = [f"{self.form.title}: {note}" for note in self._score_notes()]
        for note, dimensions in dimensions_of.items():
            whose = "" if len(dimensions) == len(self.outcomes) else f", {', '.join(dimensions)}"
            notes.append(f"{self.form.title}{whose}: {note}")
        return notes

    def _score_notes(self) -> list[str]:
        """Return notes on scores without a condition, in studies with factors."""
        known = self.scores[list(self.factors)].notna().all(axis="columns")
        is_apart = ~known if self.factors else known
        n_apart = int(is_apart.sum()) if self.factors else 0
        n_averaged = int((is_apart & (self.scores["n_answered"] > len(self.form.items))).sum())
        of_all, notes = f"of {len(self.scores)} scores", []
        if n_apart:
            where = f"answered outside the conditions, so not compared ({self.stem}_scores.csv)"
            notes.append(f"{n_apart} {of_all} without a condition: {where}")
        if n_averaged:
            why = "each averages answers given at several times (such as before and after the blocks)"
            notes.append(f"{n_averaged} {of_all}: {why}. Analyse them separately")
        return notes

    def cross(self) -> pd.DataFrame:
        """Return means with intervals as text, conditions by dimensions."""
        decimals = decimals_of(self.form.score_high - self.form.score_low)
        long = self.summary.assign(text=[_mean_text(row, decimals) for _, row in self.summary.iterrows()])
        wide = long.pivot(index="condition", columns="dimension", values="text")
        # Restore the order of conditions in the summary and of dimensions in the form after pivoting.
        return wide.loc[list(dict.fromkeys(long["condition"])), list(self.form.dimensions)].reset_index()


def _mean_text(row: "pd.Series[Any]", decimals: int) -> str:
    if pd.isna(row["mean"]):
        return f"none ({row['n_missing']} missing)"
    lost = f", {row['n_missing']} missing" if row["n_missing"] else ""
    text = interval_text(row["mean"], row["mean_low"], row["mean_high"], decimals)
    return f"{text} (n = {row['n']}{lost})"


def ratings(trials: Trials, primary: str | None = None) -> tuple[Ratings, ...]:
    """Return results of each answered questionnaire; `primary` as `outcome`."""
    return tuple(
        _ratings(_rows_of_forms(rows, trials.factors), trials.factors, form, primary)
        for form, rows in asked_forms(trials)
        if (rows["response"] != "").any()
    )


def asked_forms(trials: Trials) -> list[tuple[Questionnaire, pd.DataFrame]]:
    """Return each questionnaire that was presented, with its rows."""
    rows = asked_rows(trials)
    if not {"item", "procedure"} <= set(rows.columns):
        return []
    forms = forms_of(trials.path)
    rows = rows[(rows["task"] == FORM_TASK) & rows["procedure"].isin(forms)]
    # An empty text is a missing level.
    rows = rows.assign(**{name: rows[name].mask(rows[name].astype(object) == "") for name in trials.factors})
    return [(forms[str(name)], answers) for name, answers in rows.groupby("procedure")]


def _rows_of_forms(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return answered rows, and rows of conditions without any answer."""
    answered = rows["response"] != ""
    cells = [rows[name] for name in ("participant", *factors)]
    return rows[answered | ~answered.groupby(cells, dropna=False).transform("any").astype(bool)]


def _ratings(rows: pd.DataFrame, factors: Sequence[str], form: Questionnaire, primary: str | None) -> Ratings:
    scored = form_scores(rows, factors, form)
    varied = scored.attrs["within"]
    items = item_scores(rows, questionnaire=form, within=varied)
    profile = _with_condition(word_pairs(items), varied)
    has_patterns = are_patterns({name: scored[name].unique() for name in varied})
    has_reference = has_patterns and REFERENCE in set(scored[PATTERN])
    has_portfolio = {"PQ", "HQ"} <= set(form.dimensions)
    in_conditions, compared = scored.dropna(subset=varied), () if has_patterns or not varied else form.dimensions
    return Ratings(
        form=form,
        factors=tuple(varied),
        scores=scored,
        summary=_with_condition(summary(scored), varied),
        profile=profile,
        consistency=consistency(items),
        portfolio=_with_condition(portfolio(scored), varied) if has_portfolio else None,
        crossed=frequency_by_envelope(scored) if has_patterns else None,
        against=against_reference(scored) if has_reference else None,
        grouped=grouped_profile(profile) if has_patterns else None,
        outcomes={name: score_outcome(in_conditions, varied, name, primary) for name in compared},
    )


def form_scores(rows: pd.DataFrame, factors: Sequence[str], form: Questionnaire) -> pd.DataFrame:
    """Score a questionnaire in each combination of the factors that vary."""
    varied = [factor for factor in factors if rows[factor].nunique() > 1]
    return scores(rows, questionnaire=form, within=varied)


def are_patterns(levels: Mapping[str, Collection[object]]) -> bool:
    """Return True if the only varied factor contains the thesis's patterns.

    >>> are_patterns({"pattern": ["P0", *THESIS]}), are_patterns({"pattern": ["P1", "P2"]})
    (True, False)
    """
    return list(levels) == [PATTERN] and set(THESIS) <= set(levels[PATTERN])


def score_outcome(scored: pd.DataFrame, factors: Sequence[str], dimension: str, primary: str | None) -> Outcome:
    """Compare the scores of a dimension between conditions."""
    named = None if primary == Primary.MIXED_MODEL else primary  # scores have no measured force for a mixed model
    return outcome(scored, factors, FORM_TASK, dimension, primary=named)


def _with_condition(table: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Add a text column `condition`."""
    rows = table[list(factors)].itertuples(index=False, name=None)
    return table.assign(condition=[condition_name(factors, row) for row in rows])


NOT_SAID = "prefer not to say"
COLUMNS = ("form", "item", "question", "code", "category", "n")


def categories(trials: Trials) -> pd.DataFrame:
    """Return numbers of participants by question and category."""
    rows = asked_rows(trials)
    if not {"item", "procedure"} <= set(rows.columns):
        return pd.DataFrame(columns=list(COLUMNS))
    forms = choices_of(trials.path)
    rows = rows[(rows["task"] == FORM_TASK) & rows["procedure"].isin(forms)]
    last = rows.drop_duplicates(["participant", "procedure", "item"], keep="last")
    counted = [row for name, answers in last.groupby("procedure") for row in _counts(forms[str(name)], answers)]
    return pd.DataFrame(counted, columns=list(COLUMNS))


def _counts(form: ChoiceForm, answers: pd.DataFrame) -> Iterator[tuple[object, ...]]:
    for item in form.items:
        codes = pd.to_numeric(answers.loc[answers["item"] == item.id, "response"], errors="coerce")
        for code in item.codes if len(codes) and item.options else ():
            question = item.prompt.get("en", next(iter(item.prompt.values())))
            yield form.name, item.id, question, code, item.category(code) or NOT_SAID, int((codes == code).sum())
