"""Which of several analyses answers the question of a study: the one that its plan names, else that of a stated rule.

The rule looks at the design and at what is known of the values, never at their result. What the other analyses say are
checks: the same question put to other assumptions, no second answer.
"""

from enum import StrEnum


class Primary(StrEnum):
    """The analyses that may answer: what a plan may name."""

    ANOVA = "anova"
    CENSORED = "censored_anova"
    PERMUTATION = "permutation"
    MIXED_MODEL = "mixed_model"


TITLES = {
    Primary.ANOVA: "analysis of variance",
    Primary.CENSORED: "analysis of variance of values and bounds",
    Primary.PERMUTATION: "permutation test",
    Primary.MIXED_MODEL: "linear mixed model",
}
RULE = (
    "an analysis of variance where every participant has a value in every condition, else its likelihood from all that "
    "is known of all participants, in which a bound counts as a bound"
)


def chosen(named: str | None, *, is_whole: bool) -> tuple[Primary, str]:
    """The primary analysis, and why it is.

    >>> chosen(None, is_whole=False)
    (<Primary.CENSORED: 'censored_anova'>, 'by the rule: values are missing or bounds')
    >>> chosen("permutation", is_whole=True)
    (<Primary.PERMUTATION: 'permutation'>, 'named by the plan of analysis')
    """
    if named is not None:
        return Primary(named), "named by the plan of analysis"
    if is_whole:
        return Primary.ANOVA, "by the rule: every participant has a value in every condition"
    return Primary.CENSORED, "by the rule: values are missing or bounds"
