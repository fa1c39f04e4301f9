"""The methods paragraph, and the works that it names."""

from collections.abc import Collection, Sequence
from importlib.metadata import version

import pandas as pd

from tactometry import __version__

from ..anova.group_means import RANGES, is_of_fit
from ..means import FEWEST_IN_RANGE
from ..outcomes.findings import RULE, Outcome, Primary
from ..outcomes.ratings import Ratings
from ..plan import AnalysisPlan
from ..result import Analysis
from ..tasks.kinds import CURVES, RESULTS
from ..tasks.localisation import OF_PARTICIPANTS
from ..wording import PROCEDURES

PACKAGES = ("numpy", "scipy", "pandas", "matplotlib")
STATISTICS = {
    "pingouin": "analyses of variance within participants, tests of sphericity and normality, Holm's correction, "
    "Cronbach's alpha",
    "statsmodels": "analyses of variance of three factors or with groups of participants, linear mixed models",
}
"""Statistics that other packages compute."""
SHAPES = {
    "normal": "cumulative normal function of the level",
    "gumbel": "Gumbel function of the level (a Weibull function of the amplitude)",
}
HIERARCHICAL = (
    "As a check, all participants were also fitted at once by a hierarchical psychometric model (thresholds, "
    "logarithms of the width and logits of the lapse rate with normal effects of participants). Its posterior under "
    "weakly informative priors was integrated by Laplace's approximation and importance sampling (compare Moscatelli, "
    "Mezzetti & Lacquaniti 2012; Rue, Martino & Chopin 2009)."
)
WITHOUT_LAPSES = (
    "For comparisons this model has no lapse rate and no free asymptotes, unlike the fits of single participants: its "
    "points of equality are the middles of its curves, and its just noticeable differences are larger where "
    "participants lapse. Its effects were not tested."
)
GOODNESS = (
    "Goodness of fit was tested by the deviance, by the residuals' bend with the level and trend with time, and by "
    "their dispersion over stretches of ten trials (Wichmann & Hill 2001), each against up to 999 sets of answers "
    "drawn from the fitted function at the levels as presented and fitted anew."
)
BETWEEN = "Means over participants are given with t-intervals between participants."
WITHIN = (
    "Intervals within participants are Cousineau's with Morey's correction (Morey 2008), from values less the "
    "participant's own mean."
)
BOUNDED = (
    "Intervals of mean rates and scores are symmetric on the logit of their range, those of mean just noticeable "
    "differences on the logarithm (t quantiles, delta method), so that they hold possible values alone; fewer than "
    f"{FEWEST_IN_RANGE} participants have none."
)
PERMUTATION = "Permutation tests change the signs of participants' contrasts."
MODEL = (
    "Linear mixed models with the measured force have a random intercept per participant (restricted maximum "
    "likelihood)."
)
CENSORED_MODEL = (
    "In mixed models with bounds, which count as values below or above them, the random intercept is "
    "integrated by adaptive Gauss-Hermite quadrature (maximum likelihood)."
)
CORRECTED = (
    "Degrees of freedom of F are corrected by Chi and Muller's epsilon (Chi, Gribbin, Lamers, Gregory & Muller 2012), "
    "at least Greenhouse and Geisser's."
)
SIZES = (
    "Partial and generalised eta squared (Bakeman 2005) have 90 % intervals of the noncentral F distribution (Steiger "
    "2004)."
)
CENSORED = (
    "Where values are bounds or missing, the same normal model (one variance per stratum) was fitted to all that is "
    "known of all participants by maximum likelihood (Tobin 1958), variances multiplied by n / (n - groups): a bound "
    "counts as a value below or above it, an interval as a value within it, a missing value as missing at random; "
    "degrees of freedom are those of the design less what is not known (Satterthwaite)."
)
SIMPLE = (
    "Where an interaction is below p = .05, the effect of each factor at each value of the other (simple effects) was "
    "tested by an analysis of the values there alone, with Holm's correction over those values, and pairs were "
    "compared there."
)
PAIRS = "paired t-tests with an error of each pair's own"
GROUPS = "Welch's t-tests between groups"
CENSORED_PAIRS = "contrasts of this model with an error of each pair's own"
BAYES = "Rouder et al. 2009"
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
    "Steiger, J. H. (2004). Beyond the F test: Effect size confidence intervals and tests of close fit in the "
    "analysis of variance and contrast analysis. Psychological Methods, 9, 164-182.",
    "Rouder, J. N., Speckman, P. L., Sun, D., Morey, R. D., & Iverson, G. (2009). Bayesian t tests for "
    "accepting and rejecting the null hypothesis. Psychonomic Bulletin & Review, 16, 225-237.",
    "Schuirmann, D. J. (1987). A comparison of the two one-sided tests procedure and the power approach for "
    "assessing the equivalence of average bioavailability. Journal of Pharmacokinetics and Biopharmaceutics, 15, "
    "657-680.",
)


def methods(analysis: Analysis) -> str:
    """A paragraph for the methods section: what ran, with versions."""
    table, rows = analysis.table("thresholds"), analysis.trials.rows
    procedures = set(rows["procedure"]) if "procedure" in rows.columns else set()
    parts = [*_fit_methods(table, analysis.n_choices), *_rule_methods(table, procedures)]
    fitted = [outcome for outcome in analysis.hierarchical if outcome.fit]
    parts += [HIERARCHICAL] if fitted else []
    parts += [WITHOUT_LAPSES] if any(CURVES[outcome.task].has_difference for outcome in fitted) else []
    parts += [results.methods for task, results in RESULTS.items() if task in analysis.tables and results.methods]
    parts += [GOODNESS] if _is_tested(analysis.table(OF_PARTICIPANTS)) and GOODNESS not in parts else []
    parts += _plan_methods(analysis.plan, {name for outcome in analysis.outcomes for name in outcome.equivalence})
    parts += group_methods(analysis.outcomes, analysis.forms, analysis.plan.primary)
    parts += [f"{form.form.title} ({form.form.reference}) was scored per participant." for form in analysis.forms]
    versions = [f"tactometry {__version__}", *(f"{name} {version(name)}" for name in PACKAGES)]
    if any(outcome.primary is not None for outcome in analysis.outcomes) or analysis.forms:
        versions += [f"{name} {version(name)} ({use})" for name, use in STATISTICS.items()]
    parts.append(f"Software: {', '.join(versions)}.")
    return analysis.origin.method + " ".join(parts)


def references(methods: str) -> list[str]:
    """The works that the methods paragraph names."""
    works = (*REFERENCES, *(work for results in RESULTS.values() for work in results.works))
    # The paragraph names a work by its first author.
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


def _rule_methods(table: pd.DataFrame, procedures: Collection[str]) -> list[str]:
    if "rule_estimate" not in table.columns or table["rule_estimate"].isna().all():
        return []
    names = [words.estimate for name, words in PROCEDURES.items() if name in procedures]
    kinds = dict.fromkeys(filter(None, names))
    which = f" ({' or '.join(kinds)})" if kinds else ""
    return [f"The estimate of the rule that chose the levels{which} stands beside the fit and enters no analysis."]


def _fit_methods(table: pd.DataFrame, n_choices: Collection[int]) -> list[str]:
    if not len(table):
        return []
    fitted = [curve for task, curve in CURVES.items() if task in set(table["task"])]
    curves = " or ".join(f"a {SHAPES[name]}" for name in dict.fromkeys(table["shape"]))
    parts = [
        f"In each participant and condition {curves} with asymptotes for guesses and "
        "lapses was fitted (threshold: half of the unscaled function; Schütt, Harmeling, Macke & Wichmann 2016)."
    ]
    estimates = dict.fromkeys(f"{curve.estimate}s" for curve in fitted if not curve.has_difference)
    if estimates:
        parts.append(
            f"Detection thresholds are posterior {' or '.join(estimates)} with central 95 % intervals of the "
            "marginal posterior under psignifit 4's priors (threshold and width from the range of the levels, the "
            "width's flat in its logarithm). A threshold counts as outside of the levels where answers at an "
            "asymptote alone, or a curve that rises beyond the levels, explain the answers with a posterior "
            "probability of 0.8."
        )
    shares = " or ".join(f"1/{n}" for n in n_choices) + (", by condition" if len(n_choices) > 1 else "")
    parts += [curve.methods.format(guess_rate=shares) for curve in fitted if curve.methods]
    return [*parts, *([GOODNESS] if _is_tested(table) else [])]


def _is_tested(fits: pd.DataFrame) -> bool:
    """Whether the goodness of any of these fits was tested."""
    return len(fits) > 0 and bool(fits["deviance_p"].notna().any())


def group_methods(outcomes: Sequence[Outcome], forms: Sequence[Ratings], named: str | None) -> list[str]:
    """What was done with a group, and nothing else; `named` is the primary analysis that the plan names."""
    every = [*outcomes, *(outcome for form in forms for outcome in form.outcomes.values())]
    means = [*(outcome.group for outcome in outcomes), *(form.summary for form in forms)]
    ran = {name for outcome in every for name in outcome.analyses()}
    tested = [outcome for outcome in every if outcome.analyses().keys() & {Primary.ANOVA, Primary.CENSORED}]
    has_effects = any(form.tests_effects for form in forms)
    models = [outcome.model for outcome in every if outcome.model is not None]
    has_reference = any(form.against is not None for form in forms)
    applies = {
        BETWEEN: any(table["mean_low"].notna().any() and not is_of_fit(table) for table in means),
        BOUNDED: bool(forms) or any(outcome.dependent in RANGES for outcome in outcomes),
        WITHIN: any(table["within_low"].notna().any() for table in means),
        _primary(every, named): True,
        CORRECTED: has_effects or any(outcome.within for outcome in tested),
        SIZES: has_effects or bool(tested),
        CENSORED: any(outcome.censored is not None for outcome in every),
        PERMUTATION: Primary.PERMUTATION in ran,
        _pairs(every, has_reference=has_reference): True,
        SIMPLE: any(outcome.simple or outcome.simple_pairs for outcome in every),
        MODEL: any(not model.n_censored for model in models),
        CENSORED_MODEL: any(model.n_censored for model in models),
    }
    # Those that are composed are empty where nothing was compared.
    return [sentence for sentence, holds in applies.items() if sentence and holds]


def _primary(outcomes: Sequence[Outcome], named: str | None) -> str:
    """Which analysis answers, and by what rule it was chosen."""
    titles = [outcome.title(outcome.primary) for outcome in outcomes if outcome.primary is not None]
    if not titles:
        return ""
    rule = "named by the plan of analysis" if named else f"chosen by a rule stated before the data ({RULE})"
    has_checks = any(len(outcome.analyses()) > 1 for outcome in outcomes)
    checks = " Other analyses are checks of its assumptions, no further answers." if has_checks else ""
    return f"The primary analysis, {rule}, is the {'; the '.join(dict.fromkeys(titles))}.{checks}"


def _pairs(outcomes: Sequence[Outcome], *, has_reference: bool) -> str:
    """How conditions were compared; `has_reference`: patterns with the reference too."""
    censored = [outcome for outcome in outcomes if outcome.primary is Primary.CENSORED]
    others = [outcome for outcome in outcomes if outcome.primary is not Primary.CENSORED]
    kinds = [PAIRS] * (has_reference or any(outcome.pairs for outcome in others))
    kinds += [GROUPS] * any(outcome.group_pairs for outcome in others)
    has_bayes = bool(kinds)
    kinds += [CENSORED_PAIRS] * any(outcome.pairs or outcome.group_pairs for outcome in censored)
    if not kinds:
        return ""
    bayes = f" and Bayes factors ({BAYES})" if has_bayes else ""
    return (
        f"Conditions were compared by {', '.join(kinds)}, with Holm's correction and simultaneous 95 % intervals "
        f"(Bonferroni's, which may hold 0 where Holm's stepwise p is below .05){bayes}."
    )
