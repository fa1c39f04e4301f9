"""What is said of one dependent value: group table, analysis of variance with its checks, pairs, models."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from tactometry.analysis import apa, group
from tactometry.analysis.anova import MAX_FACTORS, permutation_test, repeated_measures
from tactometry.analysis.assumptions import checks
from tactometry.analysis.censored_model import censored_model
from tactometry.analysis.complete import largest_complete
from tactometry.analysis.design import DesignStatus, UndefinedStatistic
from tactometry.analysis.equivalence import equivalence
from tactometry.analysis.group_pairs import group_pairs
from tactometry.analysis.labels import condition_name
from tactometry.analysis.mixed_anova import mixed_anova
from tactometry.analysis.mixed_model import MixedModel, mixed_model
from tactometry.analysis.post_hoc import pairs
from tactometry.analysis.status import Status
from tactometry.errors import InvalidParameter

FORCE = "force_n"
MEASURED = "log2 of the measured force"
PURE_NUMBERS = ("exponent",)
PERMUTATION_SEED = 20_170_522
"""Of the changes of signs with many participants, so that the same data give the same report."""


@dataclass(frozen=True)
class Outcome:
    """One dependent value of one task.

    `anova` is that of the largest complete sub-design, with its `status`, `checks` and, where an error matrix is
    singular, a `permutation` test; `pairs` and `equivalence` per factor, `group_pairs` of the factor that differs
    between participants only (the analysis is then a mixed one); `model` a mixed model of all values. What could not be
    done is None, and `notes` say why.
    """

    task: str
    dependent: str
    estimates: pd.DataFrame
    group: pd.DataFrame
    cross: pd.DataFrame
    anova: pd.DataFrame | None
    notes: tuple[str, ...]
    sentences: tuple[str, ...]
    status: DesignStatus | None = None
    checks: pd.DataFrame | None = None
    permutation: pd.DataFrame | None = None
    pairs: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    equivalence: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    group_pairs: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    model: MixedModel | None = None
    model_title: str = ""

    def unit(self, of_levels: str) -> str:
        """Of the dependent value; an exponent has none."""
        return "" if self.dependent in PURE_NUMBERS else of_levels

    def all_sentences(self, of_levels: str) -> dict[str, list[str]]:
        """Every sentence, by the heading that it stands under; `of_levels` is the unit of the levels."""
        unit, _, _ = self.unit(of_levels).partition(" re ")  # a difference of decibels has no reference
        found = {
            "Analysis of variance": list(self.sentences),
            "Assumptions": [] if self.checks is None else list(self.checks["text"]),
            "Permutation tests": [] if self.permutation is None else apa.permutation_sentences(self.permutation),
        }
        for name, table in self.pairs.items():
            found[f"Pairs of {name}"] = apa.pair_sentences(table, unit)
        for name, table in self.group_pairs.items():
            found[f"Groups of {name}"] = apa.group_sentences(table, unit)
        for name, table in self.equivalence.items():
            found[f"Equivalence over {name}"] = apa.equivalence_sentences(table, unit)
        if self.model is not None:
            found[f"Linear mixed model: {self.model_title}"] = apa.model_sentences(self.model)
        return {heading: sentences for heading, sentences in found.items() if sentences}

    def tables(self, name: str) -> dict[str, pd.DataFrame]:
        """Every table, by the name of its file."""
        found: dict[str, pd.DataFrame | None] = {
            f"group_{name}": self.group,
            f"cross_{name}": self.cross,
            f"anova_{name}": self.anova,
            f"assumptions_{name}": self.checks,
            f"permutation_{name}": self.permutation,
            f"mixed_model_{name}": None if self.model is None else self.model.coefficients,
        }
        found |= {f"pairs_{name}_{factor}": table for factor, table in self.pairs.items()}
        found |= {f"groups_{name}_{factor}": table for factor, table in self.group_pairs.items()}
        found |= {f"equivalence_{name}_{factor}": table for factor, table in self.equivalence.items()}
        return {key: table for key, table in found.items() if table is not None}


def outcome(
    table: pd.DataFrame,
    factors: Sequence[str],
    task: str,
    dependent: str,
    *,
    forces: pd.DataFrame | None = None,
    bounds: Mapping[str, float] | None = None,
) -> Outcome:
    """All that is said of `dependent` in a table of estimates; `forces` has the applied force per participant and
    condition, `bounds` the differences that count as none, per factor."""
    together = group.group_table(table, factors, dependent)
    varied = [name for name in factors if table[name].nunique() > 1]
    between = [name for name in varied if table.groupby("participant")[name].nunique().max() < 2]
    inside = [name for name in varied if name not in between] if len(between) == 1 else varied
    whole, notes = _complete(table, inside, dependent)
    found = Outcome(
        task=task,
        dependent=dependent,
        estimates=table,
        group=together,
        cross=group.cross_table(together, factors),
        anova=None,
        notes=tuple(notes),
        sentences=(),
    )
    if whole is not None and inside != varied:
        found = _with_groups(found, whole[0], whole[1], between[0], bounds or {})
    elif whole is not None:
        found = _with_variance(found, whole[0], whole[1], bounds or {})
    return _with_model(found, varied, forces)


def _complete(
    table: pd.DataFrame, varied: Sequence[str], dependent: str
) -> tuple[tuple[pd.DataFrame, list[str]] | None, list[str]]:
    """The largest complete sub-design with its factors, and what was left out; or why there is none."""
    if not varied:
        return None, ["no analysis of variance: no factor has two levels"]
    if len(varied) > MAX_FACTORS:
        return None, [f"no analysis of variance: {len(varied)} factors, at most {MAX_FACTORS} can be taken"]
    if table.groupby("participant")[varied[0]].nunique().max() < 2:
        return None, [f"no analysis of variance: {varied[0]} does not vary within participants"]
    part = largest_complete(table, dependent=dependent, within=varied, subject="participant")
    if part is None:
        return None, ["no analysis of variance: no three participants share two conditions with a value"]
    notes = []
    if part.left_out:
        notes = [f"the analysis of variance uses the largest complete sub-design; left out: {', '.join(part.left_out)}"]
    return (part.table, list(part.within)), notes


def _with_variance(found: Outcome, table: pd.DataFrame, within: Sequence[str], bounds: Mapping[str, float]) -> Outcome:
    given: Any = {"dependent": found.dependent, "subject": "participant"}
    try:
        anova = repeated_measures(table, within=within, **given)
    except UndefinedStatistic as refusal:
        return replace(found, notes=(*found.notes, f"no analysis of variance: {refusal}"), status=refusal.status)
    status = anova.attrs["status"]
    is_singular = status is DesignStatus.SINGULAR
    rng = np.random.default_rng(PERMUTATION_SEED)
    return replace(
        found,
        anova=anova,
        status=status,
        notes=(*found.notes, *anova.attrs["notes"]),
        sentences=tuple(apa.anova_sentences(anova)),
        checks=checks(table, within=within, **given),
        permutation=permutation_test(table, within=within, rng=rng, **given) if is_singular else None,
        pairs={name: pairs(table, factor=name, **given) for name in within},
        equivalence=_equivalences(table, within, bounds, given),
    )


def _equivalences(
    table: pd.DataFrame, within: Sequence[str], bounds: Mapping[str, float], given: Mapping[str, Any]
) -> dict[str, pd.DataFrame]:
    kept = {name: bound for name, bound in bounds.items() if name in within}
    return {name: equivalence(table, factor=name, bound=bound, **given) for name, bound in kept.items()}


def _with_groups(
    found: Outcome, table: pd.DataFrame, within: Sequence[str], between: str, bounds: Mapping[str, float]
) -> Outcome:
    """A mixed analysis of variance of groups of participants, and which groups and conditions differ."""
    given: Any = {"dependent": found.dependent, "subject": "participant"}
    try:
        anova = mixed_anova(table, within=within, between=between, **given)
        differ = group_pairs(table, between=between, **given)
    except UndefinedStatistic as refusal:
        return replace(found, notes=(*found.notes, f"no analysis of variance: {refusal}"), status=refusal.status)
    return replace(
        found,
        anova=anova,
        status=anova.attrs["status"],
        notes=(*found.notes, *anova.attrs["notes"]),
        sentences=tuple(apa.anova_sentences(anova)),
        pairs={name: pairs(table, factor=name, **given) for name in within},
        group_pairs={between: differ},
        equivalence=_equivalences(table, within, bounds, given),
    )


def _with_model(found: Outcome, varied: Sequence[str], forces: pd.DataFrame | None) -> Outcome:
    """A mixed model of all values: with the measured force instead of its target where it was measured, else where the
    analysis of variance left something out. A censored value counts as what it is, a bound."""
    by_force = forces is not None and FORCE in varied
    lost = any("left out" in note for note in found.notes)
    data, notes = _usable(found, varied)
    if not varied or not (by_force or lost) or not data[found.dependent].notna().any():
        return found
    data, covariates = _with_force(data, forces, varied) if by_force and forces is not None else (data, [])
    factors = [name for name in varied if not (covariates and name == FORCE)]
    title = " * ".join([*factors, *covariates]) + ", participants at random"
    given: Any = {"dependent": found.dependent, "factors": factors, "covariates": covariates, "subject": "participant"}
    try:
        if data[found.dependent].notna().all():
            model = mixed_model(data, **given)
        else:
            model = censored_model(data, low="interval_low", high="interval_high", **given)
    except InvalidParameter as refusal:
        return replace(found, notes=(*found.notes, *notes, f"no mixed model: {refusal}"))
    return replace(found, model=model, model_title=title, notes=(*found.notes, *notes, *_censored_note(model)))


def _usable(found: Outcome, varied: Sequence[str]) -> tuple[pd.DataFrame, list[str]]:
    """The values that are known or censored, and a note for each condition without a single one that is known: its
    mean has no end on one side."""
    table = found.estimates
    known = table[found.dependent].notna()
    if found.dependent not in group.BOUNDED or not varied:
        return table[known], []
    has_one = known.groupby([table[name] for name in varied]).transform("any")
    censored = table["status"].isin([Status.BELOW.value, Status.ABOVE.value]) & has_one
    lost = table.loc[~has_one, list(varied)].drop_duplicates().itertuples(index=False, name=None)
    names = "; ".join(condition_name(varied, key) for key in lost)
    note = f"the mixed model leaves out: {names}, where no participant has a threshold"
    return table[known | censored], [note] if names else []


def _with_force(data: pd.DataFrame, forces: pd.DataFrame, varied: Sequence[str]) -> tuple[pd.DataFrame, list[str]]:
    keys = ["participant", *varied]
    own = forces.groupby(keys, observed=True)["force_mean_n"].mean().reset_index()
    data = data.merge(own[own["force_mean_n"] > 0], on=keys, how="inner")
    return data.assign(**{MEASURED: np.log2(data["force_mean_n"].astype(float))}), [MEASURED]


def _censored_note(model: MixedModel) -> list[str]:
    if not model.n_censored:
        return []
    counted = "1 censored threshold" if model.n_censored == 1 else f"{model.n_censored} censored thresholds"
    bounds = "its bound" if model.n_censored == 1 else "their bounds"
    return [f"the mixed model counts {counted} as what is known: below or above {bounds}"]
