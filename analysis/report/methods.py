"""The methods paragraph, and the works that it names."""

from collections.abc import Collection
from importlib.metadata import version

import pandas as pd

from ..plan import AnalysisPlan
from ..result import Analysis
from ..tasks.kinds import CURVES, RESULTS
from .group_methods import group_methods

PACKAGES = ("tactometry", "numpy", "scipy", "pandas", "statsmodels", "pingouin", "matplotlib")
SHAPES = {
    "normal": "cumulative normal function of the level",
    "gumbel": "Gumbel function of the level (a Weibull function of the amplitude)",
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


def methods(found: Analysis) -> str:
    """A paragraph for the methods section: what ran, with versions."""
    table, rows = found.table("thresholds"), found.trials.rows
    procedures = set(rows["procedure"]) if "procedure" in rows.columns else set()
    parts = [*_fit_methods(table, found.n_choices), *_rule_methods(table, procedures)]
    parts += [HIERARCHICAL] if any(each.fit for each in found.hierarchical) else []
    parts += [results.methods for task, results in RESULTS.items() if task in found.tables and results.methods]
    parts += _plan_methods(found.plan, {name for each in found.outcomes for name in each.equivalence})
    parts += group_methods(found.outcomes, found.forms, found.plan.primary)
    parts += [f"{form.form.title} ({form.form.reference}) was scored per participant." for form in found.forms]
    parts.append("Software: " + ", ".join(f"{name} {version(name)}" for name in PACKAGES) + ".")
    return found.origin.method + " ".join(parts)


def references(methods: str) -> list[str]:
    """The works that the methods paragraph names."""
    works = (*REFERENCES, *(work for results in RESULTS.values() for work in results.works))
    return sorted(work for work in works if work.partition(",")[0] in methods)


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
    fitted = [curve for task, curve in CURVES.items() if task in set(table["task"])]
    curves = " or ".join(f"a {SHAPES[name]}" for name in dict.fromkeys(table["shape"]))
    parts = [
        f"In each participant and condition {curves} with asymptotes for guesses and "
        "lapses was fitted (threshold: half of the unscaled function; Schütt, Harmeling, Macke & Wichmann 2016)."
    ]
    if not all(curve.has_difference for curve in fitted):
        parts.append(
            "Detection thresholds are posterior modes with central 95 % intervals of the marginal posterior under "
            "psignifit 4's priors (threshold and width from the range of the levels, the width's flat in its "
            "logarithm, lapse rate Beta(1, 10)). A threshold counts as outside of the levels where answers at an "
            "asymptote alone, or a curve that rises beyond the levels, explain the answers with a posterior "
            "probability of 0.8."
        )
    parts += [curve.methods.format(n_choices=n_choices) for curve in fitted if curve.methods]
    return [*parts, *([GOODNESS] if table["deviance_p"].notna().any() else [])]
