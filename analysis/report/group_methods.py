"""What was done with a group, for the methods section: the sentences of those analyses that ran."""

from collections.abc import Sequence

from ..mixed_models.linear import MixedModel
from ..outcomes.findings import Outcome
from ..outcomes.primary import RULE, Primary
from ..outcomes.ratings import Ratings

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
    "counts as a value below or above it, a missing value as missing at random; degrees of freedom are those of the "
    "design less what is not known (Satterthwaite)."
)
SIMPLE = (
    "Where an interaction is below p = .05, the effect of each factor at each value of the other (simple effects) was "
    "tested by an analysis of the values there alone, with Holm's correction over those values, and pairs were "
    "compared there."
)
PAIRS = "paired t-tests with an error of each pair's own"
GROUPS = "Welch's t-tests between groups"
CENSORED_PAIRS = "contrasts of this model with an error of each pair's own"


def group_methods(outcomes: Sequence[Outcome], forms: Sequence[Ratings], named: str | None) -> list[str]:
    """What ran, and nothing else; `named` is the primary analysis that the plan names."""
    every = [*outcomes, *(each for form in forms for each in form.outcomes.values())]
    tables = [*(each.group for each in outcomes), *(form.summary for form in forms)]
    parts = _means(has_interval=any(table["mean_low"].notna().any() for table in tables))
    if any(table["within_low"].notna().any() for table in tables):
        parts.append(
            "Intervals within participants are Cousineau's with Morey's correction (Morey 2008), from values less the "
            "participant's own mean."
        )
    parts += _primary(every, named)
    ran = {name for each in every for name in each.analyses()}
    against = any(form.tests_effects for form in forms)
    tested = [each for each in every if each.analyses().keys() & {Primary.ANOVA, Primary.CENSORED}]
    parts += [CORRECTED] if against or any(each.within for each in tested) else []
    parts += [SIZES] if against or tested else []
    parts += [CENSORED] if any(each.censored is not None for each in every) else []
    if Primary.PERMUTATION in ran:
        parts.append("Permutation tests change the signs of participants' contrasts.")
    parts += _pairs(every, any(form.against is not None for form in forms))
    parts += [SIMPLE] if any(each.simple or each.simple_pairs for each in every) else []
    return parts + _models([each.model for each in every if each.model is not None])


def _means(*, has_interval: bool) -> list[str]:
    return ["Means over participants are given with t-intervals between participants."] if has_interval else []


def _primary(outcomes: Sequence[Outcome], named: str | None) -> list[str]:
    """Which analysis answers, and by what rule it was chosen."""
    titles = list(dict.fromkeys(each.title(each.primary) for each in outcomes if each.primary is not None))
    if not titles:
        return []
    rule = "named by the plan of analysis" if named else f"chosen by a rule stated before the data ({RULE})"
    checks = any(len(each.analyses()) > 1 for each in outcomes)
    tail = " Other analyses are checks of its assumptions, no further answers." if checks else ""
    return [f"The primary analysis, {rule}, is the {'; the '.join(titles)}.{tail}"]


def _pairs(outcomes: Sequence[Outcome], is_against: bool) -> list[str]:
    """How conditions were compared; `is_against`: patterns with the reference too."""
    censored = [each for each in outcomes if each.primary is Primary.CENSORED]
    others = [each for each in outcomes if each.primary is not Primary.CENSORED]
    kinds = [PAIRS] * (is_against or any(each.pairs for each in others))
    kinds += [GROUPS] * any(each.group_pairs for each in others)
    kinds += [CENSORED_PAIRS] * any(each.pairs or each.group_pairs for each in censored)
    if not kinds:
        return []
    bayes = any(kind in (PAIRS, GROUPS) for kind in kinds)
    return [
        f"Conditions were compared by {', '.join(kinds)}, with Holm's correction and simultaneous 95 % intervals "
        "(Bonferroni's, which may hold 0 where Holm's stepwise p is below .05)"
        + (" and Bayes factors (Rouder et al. 2009; by pingouin, Vallat 2018)." if bayes else ".")
    ]


def _models(models: Sequence[MixedModel]) -> list[str]:
    known = [model for model in models if not model.n_censored]
    parts = []
    if known:
        parts.append(
            "Linear mixed models with the measured force have a random intercept per participant (restricted maximum "
            "likelihood)."
        )
    if len(known) < len(models):
        parts.append(
            "In mixed models with bounds, which count as values below or above them, the random intercept is "
            "integrated by adaptive Gauss-Hermite quadrature (maximum likelihood)."
        )
    return parts
