"""Sentences of a report, made from the numbers."""

from collections.abc import Collection, Sequence
from importlib.metadata import version

import numpy as np
import pandas as pd

from tactometry.trials.tasks import FORM_TASK

from ..attrakdiff.ratings import Ratings, unanswered
from ..outcomes.findings import Outcome
from ..plan import AnalysisPlan
from ..reading.study_file import forms_of
from ..reading.trials import Trials
from ..tasks.cells import FITTED_TASKS
from ..tasks.measurement import TASK as MEASURED_TASK
from ..threshold.status import Status
from ..wording.labels import named_cells
from ..wording.numbers import percent_text
from .group_methods import group_methods

PACKAGES = ("tactometry", "numpy", "scipy", "pandas", "statsmodels", "pingouin", "matplotlib")
MANY_FALSE_ALARMS = 0.25
MANY_INVALID = 0.2
MANY_DROPPED = 0.01
"""Shares above these are warned of; unverified defaults."""
FEW_TRIALS = 15
STATUS_WORDS = {
    Status.BELOW: "with a threshold below the levels: its upper bound is given",
    Status.ABOVE: "with a threshold above the levels: its lower bound is given",
    Status.SEPARATED: "with one step between two levels: the width has an upper bound only",
    Status.FLAT: "without a rise with the level: no threshold is given",
    Status.NON_MONOTONE: "with a fall somewhere at rising level, more than chance explains",
    Status.TOO_FEW_LEVELS: "with fewer than three levels",
    Status.NO_DATA: "without a trial at a level",
}


def plain_rows(table: pd.DataFrame) -> list[dict[str, object]]:
    """Rows as plain values: None for what is missing."""
    return [{str(name): _plain(value) for name, value in row.items()} for row in table.to_dict("records")]


def _plain(value: object) -> object:
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value


def warnings(trials: Trials, table: pd.DataFrame, quality: pd.DataFrame, n_choices: int) -> tuple[str, ...]:
    """What a reader must know before the numbers."""
    of_fits = []
    if len(table):
        of_fits = [*missing_cells(table, trials.factors), *_status_warnings(table, trials.factors)]
        of_fits += _few_trials(table, trials.factors)
        of_fits += _answer_warnings(trials, table, n_choices)
    return (*of_fits, *_other_tasks(trials), *unanswered(trials), *_quality_warnings(quality))


def exclusion_warnings(excluded: pd.DataFrame) -> list[str]:
    """One for each rule that left something out."""
    return [
        f"left out by the rule {rule} = {part['bound'].iloc[0]:g}, numbers of trials: "
        + ", ".join(f"{code} {n}" for code, n in zip(part["participant"], part["n_trials"], strict=True))
        for rule, part in excluded.groupby("rule", sort=False)
    ]


def missing_cells(table: pd.DataFrame, factors: Sequence[str]) -> list[str]:
    """Conditions that others have and a participant has not; a factor that varies between participants alone is none of
    theirs."""
    found = []
    for task, part in table.groupby("task", sort=False):
        inside = [name for name in factors if part.groupby("participant")[name].nunique().max() > 1]
        conditions = part[inside].drop_duplicates()
        whole = part[["participant"]].drop_duplicates().merge(conditions, how="cross")
        held = whole.merge(part[["participant", *inside]].drop_duplicates(), how="left", indicator=True)
        lost = held[held["_merge"] == "left_only"].sort_values(["participant", *inside])
        if len(lost):
            found.append(
                f"{len(lost)} of {len(held)} cells of {task} without a valid trial ({named_cells(lost, inside)})"
            )
    return found


def _status_warnings(table: pd.DataFrame, factors: Sequence[str]) -> list[str]:
    found = []
    for status, text in STATUS_WORDS.items():
        part = table[table["status"] == status.value]
        if len(part):
            found.append(f"{len(part)} of {len(table)} cells {text} ({named_cells(part, factors)})")
    return found


def _few_trials(table: pd.DataFrame, factors: Sequence[str]) -> list[str]:
    part = table[table["n_trials"] < FEW_TRIALS]
    if not len(part):
        return []
    return [
        f"{len(part)} of {len(table)} cells with fewer than {FEW_TRIALS} trials: such intervals rest on the priors "
        f"({named_cells(part, factors)})"
    ]


def _answer_warnings(trials: Trials, table: pd.DataFrame, n_choices: int) -> list[str]:
    found = []
    yes_no = table[table["task"] == "yes_no"]
    if len(yes_no) and not yes_no["n_catch"].sum():
        found.append("no catch trials in a yes/no task: the guess rate rests on its prior alone")
    choice = trials.rows["task"] == "forced_choice"
    if choice.any() and "target" not in trials.rows.columns:
        found.append(
            f"no column 'target' in a forced choice: {n_choices} alternatives were taken from the answers given"
        )
    return found


def _other_tasks(trials: Trials) -> list[str]:
    rows = trials.rows
    known = rows["task"].isin((*FITTED_TASKS, MEASURED_TASK, *CHOICES))
    if "procedure" in rows.columns:
        known |= (rows["task"] == FORM_TASK) & rows["procedure"].isin(forms_of(trials.path))
    other = rows[~known]
    if not len(other):
        return []
    return [f"not analysed here, rows of other tasks: {len(other)} ({', '.join(sorted(other['task'].unique()))})"]


def _frame_warnings(quality: pd.DataFrame) -> list[str]:
    due = quality["n_frames"] + quality["n_dropped_frames"]
    lost = quality.assign(n_due=due)[quality["n_dropped_frames"] > MANY_DROPPED * due]
    if not len(lost):
        return []
    names = [f"{row.participant} {row.n_dropped_frames} of {row.n_due}" for row in lost.itertuples(index=False)]
    return [f"more than {percent_text(MANY_DROPPED)} of the screen's frames dropped: {', '.join(names)}"]


def _quality_warnings(quality: pd.DataFrame) -> list[str]:
    found = []
    many = quality[quality["false_alarm_rate"] > MANY_FALSE_ALARMS]
    if len(many):
        names = ", ".join(
            f"{code} {percent_text(rate)}"
            for code, rate in zip(many["participant"], many["false_alarm_rate"], strict=True)
        )
        found.append(f"more than {percent_text(MANY_FALSE_ALARMS)} false alarms in catch trials: {names}")
    if "n_dropped_frames" in quality.columns:
        found += _frame_warnings(quality)
    invalid = quality[quality["n_invalid"] > MANY_INVALID * quality["n_rows"]]
    if len(invalid):
        found.append(f"more than {percent_text(MANY_INVALID)} invalid trials: {', '.join(invalid['participant'])}")
    return found


CURVES = {
    "normal": "cumulative normal function of the level",
    "gumbel": "Gumbel function of the level (a Weibull function of the amplitude)",
}


CHOICES = {
    "same_different": "Sensitivity in same-different trials is given under the differencing and the "
    "independent-observation rule (Macmillan & Creelman 2005), with the log-linear correction.",
    "preference": "Paired preferences were fitted by the Bradley-Terry model with an effect of the order (Bradley & "
    "Terry 1952), with 95 % intervals that from five participants on count that a person's answers are alike.",
    "adjustment": "Settings of the method of adjustment were averaged per participant and condition (Gescheider 1997).",
    "magnitude": "Exponents of the power law are slopes of the logarithm of each participant's geometric mean number "
    "over that of the amplitude, every level alike (Stevens 1957); numbers of 0 were left out. Geometric means over "
    "participants follow modulus equalisation (Lane, Catania & Stevens 1961).",
}
HIERARCHICAL = (
    "As a check, all participants were also fitted at once by a hierarchical psychometric model (thresholds and "
    "logarithms of the width with normal effects of participants, rates the same for all; maximum likelihood by "
    "Laplace's approximation; compare Moscatelli, Mezzetti & Lacquaniti 2012)."
)
GOODNESS = (
    "Goodness of fit was tested by the deviance, by the residuals' bend with the level and trend with time, and by "
    "their dispersion over stretches of ten trials (Wichmann & Hill 2001), each against up to 999 sets of answers "
    "drawn from the fitted function at the levels as presented and fitted anew."
)
REFERENCES = (
    "Macmillan, N. A., & Creelman, C. D. (2005). Detection theory: A user's guide (2nd ed.). Erlbaum.",
    "Gescheider, G. A. (1997). Psychophysics: The fundamentals (3rd ed.). Erlbaum.",
    "Stevens, S. S. (1957). On the psychophysical law. Psychological Review, 64, 153-181.",
    "Lane, H. L., Catania, A. C., & Stevens, S. S. (1961). Voice level: Autophonic scale, perceived loudness, and "
    "effects of sidetone. Journal of the Acoustical Society of America, 33, 160-167.",
    "Bradley, R. A., & Terry, M. E. (1952). Rank analysis of incomplete block designs: I. The method of "
    "paired comparisons. Biometrika, 39, 324-345.",
    "Moscatelli, A., Mezzetti, M., & Lacquaniti, F. (2012). Modeling psychophysical data at the "
    "population-level: The generalized linear mixed model. Journal of Vision, 12(11), 26.",
    "Wichmann, F. A., & Hill, N. J. (2001). The psychometric function: I. Fitting, sampling, and goodness of fit. "
    "Perception & Psychophysics, 63, 1293-1313.",
    "Schütt, H. H., Harmeling, S., Macke, J. H., & Wichmann, F. A. (2016). Painfree and accurate Bayesian "
    "estimation of psychometric functions for (potentially) overdispersed data. Vision Research, 122, 105-123.",
    "Bakeman, R. (2005). Recommended effect size statistics for repeated measures designs. Behavior Research "
    "Methods, 37, 379-384.",
    "Chi, Y.-Y., Gribbin, M., Lamers, Y., Gregory, J. F., & Muller, K. E. (2012). Global hypothesis testing for "
    "high-dimensional repeated measures outcomes. Statistics in Medicine, 31, 724-742.",
    "Morey, R. D. (2008). Confidence intervals from normalized data: A correction to Cousineau (2005). Tutorials in "
    "Quantitative Methods for Psychology, 4, 61-64.",
    "Tobin, J. (1958). Estimation of relationships for limited dependent variables. Econometrica, 26, 24-36.",
    "Vallat, R. (2018). Pingouin: statistics in Python. Journal of Open Source Software, 3(31), 1026.",
    "Steiger, J. H. (2004). Beyond the F test: Effect size confidence intervals and tests of close fit in the "
    "analysis of variance and contrast analysis. Psychological Methods, 9, 164-182.",
    "Rouder, J. N., Speckman, P. L., Sun, D., Morey, R. D., & Iverson, G. (2009). Bayesian t tests for "
    "accepting and rejecting the null hypothesis. Psychonomic Bulletin & Review, 16, 225-237.",
    "Schuirmann, D. J. (1987). A comparison of the two one-sided tests procedure and the power approach for "
    "assessing the equivalence of average bioavailability. Journal of Pharmacokinetics and Biopharmaceutics, 15, "
    "657-680.",
)


def methods(
    table: pd.DataFrame,
    n_choices: int,
    forms: Sequence[Ratings] = (),
    plan: AnalysisPlan | None = None,
    *,
    is_hierarchical: bool = False,
    choices: Sequence[str] = (),
    outcomes: Sequence[Outcome] = (),
    procedures: Collection[str] = (),
) -> str:
    """A paragraph for the methods section: what ran, with versions."""
    plan = plan or AnalysisPlan()
    parts = [*_fit_methods(table, n_choices), *_rule_methods(table, procedures)]
    parts += [HIERARCHICAL] if is_hierarchical else []
    parts += [CHOICES[name] for name in choices]
    parts += _plan_methods(plan, {name for each in outcomes for name in each.equivalence})
    parts += group_methods(outcomes, forms, plan.primary)
    parts += [f"{form.form.title} ({form.form.reference}) was scored per participant." for form in forms]
    parts.append("Software: " + ", ".join(f"{name} {version(name)}" for name in PACKAGES) + ".")
    return " ".join(parts)


def references(methods: str) -> list[str]:
    """The works that the methods paragraph names."""
    return sorted(work for work in REFERENCES if work.partition(",")[0] in methods)


def _plan_methods(plan: AnalysisPlan, tested: Collection[str]) -> list[str]:
    stated = plan.exclusion.stated()
    parts = []
    if stated:
        rules = ", ".join(f"{name} = {bound:g}" for name, bound in stated.items())
        parts.append(f"Trials and participants were left out by rules stated beforehand ({rules}).")
    return parts + [
        f"Levels of {name} count as equivalent if two one-sided tests (Schuirmann 1987) put their difference within "
        f"+-{bound:g}, a bound stated beforehand."
        for name, bound in plan.equivalence.items()
        if name in tested
    ]


REVERSALS, POSTERIOR_MEAN = "mean of the reversals without the first two or three, in even number", "posterior mean"
RULE_ESTIMATES = {
    "staircase": REVERSALS, "weighted_staircase": REVERSALS, "method_of_limits": "mean of the transitions",
    "quest": POSTERIOR_MEAN, "quest_plus": POSTERIOR_MEAN, "psi": POSTERIOR_MEAN,
}  # fmt: skip


def _rule_methods(table: pd.DataFrame, procedures: Collection[str]) -> list[str]:
    if "rule_estimate" not in table.columns or table["rule_estimate"].isna().all():
        return []
    kinds = dict.fromkeys(RULE_ESTIMATES[name] for name in RULE_ESTIMATES if name in procedures)
    told = f" ({' or '.join(kinds)})" if kinds else ""
    return [f"The estimate of the rule that chose the levels{told} stands beside the fit and enters no analysis."]


def _fit_methods(table: pd.DataFrame, n_choices: int) -> list[str]:
    if not len(table):
        return []
    tasks = set(table["task"])
    curves = " or ".join(f"a {CURVES[name]}" for name in dict.fromkeys(table["shape"]))
    parts = [
        f"In each participant and condition {curves} with asymptotes for guesses and "
        "lapses was fitted (threshold: half of the unscaled function; Schütt, Harmeling, Macke & Wichmann 2016)."
    ]
    if tasks & {"yes_no", "forced_choice"}:
        parts.append(
            "Detection thresholds are posterior modes with central 95 % intervals of the marginal posterior under "
            "psignifit 4's priors (threshold and width from the range of the levels, the width's flat in its "
            "logarithm, lapse rate Beta(1, 10)). A threshold counts as outside of the levels where answers at an "
            "asymptote alone, or a curve that rises beyond the levels, explain the answers with a posterior "
            "probability of 0.8."
        )
    if "yes_no" in tasks:
        parts.append("The guess rate of yes/no answers was free (Beta(1, 10)) and bound by the catch trials.")
    if "forced_choice" in tasks:
        parts.append(f"The guess rate of forced choices was 1/{n_choices}.")
    if "comparison" in tasks:
        parts.append(
            "Points of subjective equality and just noticeable differences (0.6745 standard deviations) of comparisons "
            "are posterior modes with central 95 % intervals of the marginal posterior. Both asymptotes were equally "
            "far from 0 and 1 (one rate, Beta(1, 80)), as of lapses that go either way with the same chance; the prior "
            "of the width was flat in its logarithm from the smallest spacing of the levels to their range."
        )
    return [*parts, *([GOODNESS] if table["deviance_p"].notna().any() else [])]
