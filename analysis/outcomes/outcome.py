"""Computation of the `Outcome` of a table of estimates."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from tactometry.errors import InvalidParameter

from ..anova.bounded_design import MIN_KNOWN, SubDesign, largest_complete, largest_known
from ..anova.censored import CensoredAnova, censored_anova, censored_equivalence, censored_group_pairs, censored_pairs
from ..anova.design import MAX_FACTORS, DesignStatus, UndefinedStatistic, reason_of
from ..anova.group_means import HIGH, LOW, bounds_of, group_table
from ..anova.post_hoc import Analysis, all_together, equivalence, interaction_orders, pairs, simple_effects
from ..anova.split_plot import group_pairs, mixed_anova
from ..anova.within_subjects import checks, permutation_test, repeated_measures
from ..mixed_models.censored import censored_model
from ..mixed_models.linear import mixed_model
from ..wording import cross_table
from .findings import FORCE, TITLES, Outcome, Primary, primary_analysis

MEASURED = "log2 of the measured force"
PERMUTATION_SEED = 20_170_522
"""Seed of permutation tests with many participants, so that equal data yield equal reports."""
SUBJECT = "participant"
INTERVAL = 0.95


@dataclass(frozen=True)
class EstimateDesign:
    """Analysis of estimates, some of which are bounds, over within- or between-participant factors."""

    table: pd.DataFrame
    dependent: str
    within: tuple[str, ...]
    between: str | None

    @classmethod
    def of(cls, estimates: pd.DataFrame, factors: Sequence[str], dependent: str) -> "EstimateDesign":
        varied = [name for name in factors if estimates[name].nunique() > 1]
        fixed = [name for name in varied if estimates.groupby(SUBJECT)[name].nunique().max() < 2]
        apart = len(fixed) == 1  # no analysis supports several between-participants factors
        within = tuple(name for name in varied if not (apart and name in fixed))
        return cls(bounds_of(estimates, dependent), dependent, within, fixed[0] if apart else None)

    @property
    def factors(self) -> list[str]:
        return [*([self.between] if self.between else []), *self.within]

    @property
    def arguments(self) -> dict[str, Any]:
        return {"dependent": self.dependent, "subject": SUBJECT}

    @property
    def is_whole(self) -> bool:
        """Return True if every participant has a value in every condition."""
        known = self.table[self.table[self.dependent].notna()]
        n_cells = int(np.prod([self.table[name].nunique() for name in self.within]))
        has = known.drop_duplicates([SUBJECT, *self.within]).groupby(SUBJECT).size()
        return len(has) == self.table[SUBJECT].nunique() and bool((has == n_cells).all())


def outcome(
    table: pd.DataFrame,
    factors: Sequence[str],
    task: str,
    dependent: str,
    *,
    forces: pd.DataFrame | None = None,
    bounds: Mapping[str, float] | None = None,
    primary: str | None = None,
    compared: bool = True,
) -> Outcome:
    """Analyse `dependent` in a table of estimates.

    `forces` contains the applied force of each participant and condition, `bounds` the equivalence bound of each
    factor. `primary` names the primary analysis; by default a rule chooses it. Without `compared`, pairs and simple
    effects are omitted.
    """
    design = EstimateDesign.of(table, factors, dependent)
    group = group_table(table, factors, dependent)
    result = Outcome(task, dependent, table, group, cross_table(group, factors), design.within, design.between)
    complete, notes = _complete_part(design)
    result = replace(result, notes=notes)
    if complete is not None:
        result = _with_anova(result, design, complete, permuted=primary == Primary.PERMUTATION)
    if not design.is_whole or primary == Primary.CENSORED:
        result = _with_censored(result, design, factors)
    if forces is not None and FORCE in design.within:
        result = _with_model(result, design, forces)
    if design.factors:  # last, as only an analysis with a result can be primary
        result = _with_losses(_with_primary(result, primary, is_whole=design.is_whole))
    if not compared:
        return result
    if result.primary is Primary.CENSORED and result.censored is not None:
        return _with_comparisons(result, _comparison_of_censored(design, result.censored), bounds or {})
    if result.anova is None or complete is None:
        return result
    return _with_comparisons(result, _comparison_of_complete(design, result.anova, complete), bounds or {})


def _complete_part(design: EstimateDesign) -> tuple[SubDesign | None, tuple[str, ...]]:
    """Return the largest complete subset, or notes on why there is none."""
    within = design.within
    if not design.factors:
        return None, ("no analysis of variance: no factor has two levels",)
    if len(within) > MAX_FACTORS:
        return None, (f"no analysis of variance: {len(within)} factors, at most {MAX_FACTORS} are supported",)
    n_levels = design.table.groupby(SUBJECT)[design.factors].nunique().max()
    fixed = [name for name in within if n_levels[name] < 2]
    if fixed:
        return None, (f"no analysis of variance: {fixed[0]} does not vary within participants",)
    if not within:  # only groups: keep the participants with a value
        known = design.table[design.dependent].notna()
        left_out = tuple(f"participant {code}" for code in design.table[SUBJECT][~known])
        return SubDesign(design.table[known], (), left_out), ()
    largest = largest_complete(design.table, within=within, **design.arguments)
    if largest is None:
        return None, ("no analysis of variance: fewer than 3 participants have a value in the same 2 conditions",)
    return largest, ()


def _with_anova(result: Outcome, design: EstimateDesign, complete: SubDesign, *, permuted: bool) -> Outcome:
    """Add the ANOVA of the complete subset, and a permutation test if needed."""
    within, arguments = list(complete.within), design.arguments
    result = replace(result, left_out=complete.left_out)
    try:
        anova = _anova(design, complete.table, within)
    except UndefinedStatistic as refusal:
        return replace(result.noted(f"no analysis of variance: {reason_of(refusal)}"), status=refusal.status)
    status = anova.attrs["status"]
    result = replace(result.noted(*anova.attrs["notes"]), anova=anova, status=status)
    if design.between is not None:
        return result
    result = replace(result, checks=checks(complete.table, anova, within=within, **arguments))
    if not (permuted or status is DesignStatus.SINGULAR):
        return result
    # The test is exact for few participants and uses the generator for more.
    rng = np.random.default_rng(PERMUTATION_SEED)
    return replace(result, permutation=permutation_test(complete.table, within=within, rng=rng, **arguments))


def _anova(design: EstimateDesign, table: pd.DataFrame, within: Sequence[str]) -> pd.DataFrame:
    if not within:  # if all values are known, it equals the analysis of variance
        return _censored_anova(design, table, within).table
    if design.between is None or table[design.between].nunique() < 2:
        return repeated_measures(table, within=within, **design.arguments)
    return mixed_anova(table, within=within, between=design.between, **design.arguments)


def _with_censored(result: Outcome, design: EstimateDesign, factors: Sequence[str]) -> Outcome:
    """Add the analysis with censored values, and its group means."""
    if len(design.within) > MAX_FACTORS:
        return result
    kept: SubDesign | None = SubDesign(design.table, (), ())
    if design.within:
        options: dict[str, Any] = {"between": design.between, "at_least": MIN_KNOWN}
        kept = largest_known(design.table, within=design.within, **design.arguments, **options)
    if kept is None:
        note = f"no analysis with censored values: fewer than 2 conditions have {MIN_KNOWN} participants with a value"
        return result.noted(note)
    try:
        censored = _censored_anova(design, kept.table, kept.within)
    except InvalidParameter as refusal:
        return result.noted(f"no analysis with censored values: {reason_of(refusal)}")
    means = censored.means()
    # A factor of which one level remains has the means of that level.
    means = means.assign(**{name: kept.table[name].iloc[0] for name in factors if name not in means.columns})
    group = group_table(result.estimates, factors, result.dependent, model=means)
    notes = _count_notes(censored)
    if kept.left_out:
        names = f"leaves out {', '.join(kept.left_out)}"
        why = f"in some of its conditions, fewer than {MIN_KNOWN} participants have a value"
        notes.append(f"the analysis with censored values {names}: {why}")
    return replace(result.noted(*notes), censored=censored, group=group, cross=cross_table(group, factors))


def _censored_anova(design: EstimateDesign, table: pd.DataFrame, within: Sequence[str]) -> CensoredAnova:
    between = design.between if design.between and table[design.between].nunique() > 1 else None
    return censored_anova(table, low=LOW, high=HIGH, within=list(within), between=between, **design.arguments)


def _count_notes(model: CensoredAnova) -> list[str]:
    """Return a note on how the analysis treats unknown values."""
    data = model.design.data
    n_intervals = int((~data.known & np.isfinite(data.low) & np.isfinite(data.high)).sum())
    kinds = [
        (model.design.n_censored - n_intervals, "as a bound", "as bounds"),
        (n_intervals, "as an interval", "as intervals"),
        (model.design.n_missing, "as missing at random", "as missing at random"),
    ]
    counts = [f"{n} value{'s' if n > 1 else ''} {many if n > 1 else one}" for n, one, many in kinds if n]
    return [f"the analysis with censored values treats {' and '.join(counts)}"] if counts else []


def _with_model(result: Outcome, design: EstimateDesign, forces: pd.DataFrame) -> Outcome:
    """Add a mixed model with the measured force instead of the target."""
    keys = [SUBJECT, *design.factors]
    measured = forces.groupby(keys, observed=True)["force_mean_n"].mean().reset_index()
    data = design.table.merge(measured[measured["force_mean_n"] > 0], on=keys, how="inner")  # 0 has no logarithm
    known = data[design.dependent].notna()
    data = data[known | data[[LOW, HIGH]].notna().any(axis=1)]
    data = data.assign(**{MEASURED: np.log2(data["force_mean_n"].astype(float))})
    factors = [name for name in design.factors if name != FORCE]
    fit = mixed_model if known.all() else partial(censored_model, low=LOW, high=HIGH)
    try:
        model = fit(data, factors=factors, covariates=[MEASURED], **design.arguments)
    except InvalidParameter as refusal:
        return result.noted(f"no mixed model: {reason_of(refusal)}")
    title = " * ".join([*factors, MEASURED]) + ", random intercept of participants"
    return replace(result, model=model, model_title=title)


def _with_primary(result: Outcome, named: str | None, *, is_whole: bool) -> Outcome:
    primary, reason = primary_analysis(named, is_whole=is_whole, between=result.between, within=result.within)
    if primary not in result.analyses():
        if not result.analyses() and named in (None, Primary.ANOVA):  # a note already states the reason
            return result
        note = f"no primary analysis: {TITLES[primary]} ({reason}) has no result"
        return result.noted(note)
    return replace(result, primary=primary, reason=reason)


def _with_losses(result: Outcome) -> Outcome:
    """Add a note on what the analysis of the complete subset leaves out."""
    if result.anova is None or not result.left_out:
        return result
    is_primary = result.primary in (Primary.ANOVA, Primary.PERMUTATION)
    which, chance = "the analysis of variance, a check,", ""
    if is_primary:
        which, chance = "the primary analysis", ". This is unbiased only if values are out of range at random"
    note = f"{which} leaves out {', '.join(result.left_out)}, as it needs a value in every condition{chance}"
    return result.noted(note)


@dataclass(frozen=True)
class _Comparison:
    """Functions that compare conditions in the same way as an analysis."""

    effects: pd.DataFrame
    kept: SubDesign
    between: str | None
    analysis: Analysis
    pairs: Callable[[str, str | None], pd.DataFrame]
    equivalence: Callable[..., pd.DataFrame]


def _with_comparisons(result: Outcome, comparison: _Comparison, bounds: Mapping[str, float]) -> Outcome:
    table, within, between = comparison.kept.table, comparison.kept.within, comparison.between
    orders = interaction_orders(comparison.effects, [*([between] if between else []), *within])
    tested = [name for name in bounds if name in within]
    inside = [(name, by) for name, by in orders if name != between]
    return replace(
        result,
        pairs={name: comparison.pairs(name, None) for name in within},
        group_pairs={between: comparison.pairs(between, None)} if between else {},
        equivalence={name: comparison.equivalence(factor=name, bound=bounds[name]) for name in tested},
        simple={(name, by): simple_effects(comparison.analysis, table, within, name, by) for name, by in inside},
        simple_pairs={(name, by): comparison.pairs(name, by) for name, by in orders},
    )


def _comparison_of_complete(design: EstimateDesign, effects: pd.DataFrame, complete: SubDesign) -> _Comparison:
    table = complete.table

    def compare(factor: str, by: str | None) -> pd.DataFrame:
        if factor == design.between:
            return group_pairs(table, between=factor, by=by, **design.arguments)
        if by is None or by != design.between:
            return pairs(table, factor=factor, by=by, **design.arguments)
        # Groups differ in participants: compare within each group, then correct for all pairs at once.
        of_groups = []
        for value, members in table.groupby(by, sort=True):
            alone = pairs(members, factor=factor, correction="none", **design.arguments)
            of_groups.append(alone.assign(**{by: value}))
        return all_together(pd.concat(of_groups, ignore_index=True), "holm", INTERVAL)

    within_bound = partial(equivalence, table, **design.arguments)
    return _Comparison(effects, complete, design.between, partial(_anova, design), compare, within_bound)


def _comparison_of_censored(design: EstimateDesign, model: CensoredAnova) -> _Comparison:
    table, within, between = design.table, model.design.factors, model.design.between
    for name, levels in zip(within, model.design.levels, strict=True):
        table = table[table[name].isin(levels)]

    def analysis(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
        return _censored_anova(design, rows, factors).table

    def compare(factor: str, by: str | None) -> pd.DataFrame:
        return censored_group_pairs(model, by=by) if factor == between else censored_pairs(model, factor, by=by)

    within_bound = partial(censored_equivalence, model)
    return _Comparison(model.table, SubDesign(table, within, ()), between, analysis, compare, within_bound)
