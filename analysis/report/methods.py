"""Methods paragraph of a report, and its references."""

from collections.abc import Iterator, Sequence
from importlib.metadata import version

import pandas as pd

from tactometry import __version__

from ..anova.group_means import RANGES, is_of_fit
from ..means import FEWEST_IN_RANGE
from ..outcomes.findings import RULE, Outcome, Primary
from ..outcomes.ratings import Ratings
from ..result import Analysis
from ..tasks import preference
from ..tasks.kinds import CURVES, RESULTS
from ..tasks.localisation import OF_PARTICIPANTS
from ..wording import PROCEDURES
from .texts import paragraph, source

PACKAGES = ("numpy", "scipy", "pandas", "matplotlib")
SHAPES = {
    "normal": "a cumulative normal function of the level",
    "gumbel": "a Gumbel function of the level (a Weibull function of the amplitude)",
}


def methods(analysis: Analysis) -> str:
    """Return a methods paragraph on the analyses that ran, with versions."""
    fitted = [outcome.task for outcome in analysis.hierarchical if outcome.fit]
    used = {name for outcome in analysis.outcomes for name in outcome.equivalence}
    packages = [f"{name} {version(name)}" for name in PACKAGES]
    text = paragraph(
        "methods.j2",
        **_fits(analysis),
        **_rules(analysis),
        hierarchical=fitted,
        hierarchical_comparisons=any(CURVES[task].has_difference for task in fitted),
        task_methods=[results.methods for task, results in RESULTS.items() if task in analysis.tables],
        tests_resolutions=_is_tested(analysis.table(OF_PARTICIPANTS)),
        exclusions=analysis.plan.exclusion.stated(),
        equivalence={name: bound for name, bound in analysis.plan.equivalence.items() if name in used},
        group=group_methods(analysis.outcomes, analysis.forms, analysis.plan.primary),
        forms=[form.form for form in analysis.forms],
        versions=[f"tactometry {__version__}", *packages, *_libraries(analysis)],
    )
    return analysis.origin.method + text


def references(methods: str) -> list[str]:
    """Return the works that the methods paragraph cites."""
    works = (*source("references.txt").splitlines(), *(work for results in RESULTS.values() for work in results.works))
    # the paragraph cites each work by its first author
    return sorted(work for work in works if work.partition(",")[0] in methods)


def _fits(analysis: Analysis) -> dict[str, object]:
    table, n_choices = analysis.table("thresholds"), analysis.n_choices
    fitted = [curve for task, curve in CURVES.items() if len(table) and task in set(table["task"])]
    shares = " or ".join(f"1/{n}" for n in n_choices) + (", by condition" if len(n_choices) > 1 else "")
    return {
        "curves": [SHAPES[name] for name in dict.fromkeys(table["shape"])] if fitted else [],
        "estimates": list(dict.fromkeys(f"{curve.estimate}s" for curve in fitted if not curve.has_difference)),
        "curve_methods": [curve.methods.format(guess_rate=shares) for curve in fitted],
        "tests_curves": _is_tested(table),
    }


def _is_tested(fits: pd.DataFrame) -> bool:
    """Return True if goodness of fit was tested for any of these fits."""
    return len(fits) > 0 and bool(fits["deviance_p"].notna().any())


def _rules(analysis: Analysis) -> dict[str, object]:
    table, rows = analysis.table("thresholds"), analysis.trials.rows
    procedures = set(rows["procedure"]) if "procedure" in rows.columns else set()
    kinds = [words.estimate for name, words in PROCEDURES.items() if name in procedures and words.estimate]
    has_rule = "rule_estimate" in table.columns and bool(table["rule_estimate"].notna().any())
    return {"has_rule": has_rule, "rules": list(dict.fromkeys(kinds))}


def _libraries(analysis: Analysis) -> Iterator[str]:
    """Yield each statistics package that was used, with its version and uses."""
    outcomes = [*analysis.outcomes, *(outcome for form in analysis.forms for outcome in form.outcomes.values())]
    anovas = [outcome.anova.attrs.get("library") for outcome in outcomes if outcome.anova is not None]
    anovas += ["pingouin" for form in analysis.forms if form.crossed is not None]
    compares = any(outcome.pairs or outcome.group_pairs or outcome.simple for outcome in outcomes)
    compares = compares or any(form.against is not None for form in analysis.forms)
    of_pingouin = {
        "analyses of variance within participants": "pingouin" in anovas,
        "tests of sphericity and normality": any(outcome.checks is not None for outcome in outcomes),
        "Holm's correction": compares,
        "Cronbach's alpha": any(form.consistency["alpha"].notna().any() for form in analysis.forms),
    }
    of_statsmodels = {
        "analyses of variance with three factors or groups of participants": "statsmodels" in anovas,
        "Bradley-Terry worths": preference.TASK in analysis.tables,
        "linear mixed models": any(outcome.model is not None and not outcome.model.n_censored for outcome in outcomes),
    }
    for name, uses in (("pingouin", of_pingouin), ("statsmodels", of_statsmodels)):
        ran = [use for use, did_run in uses.items() if did_run]
        if ran:
            yield f"{name} {version(name)} ({', '.join(ran)})"


def group_methods(outcomes: Sequence[Outcome], forms: Sequence[Ratings], named: str | None) -> str:
    """Describe the group analyses; `named` is the plan's primary analysis."""
    every = [*outcomes, *(outcome for form in forms for outcome in form.outcomes.values())]
    means = [*(outcome.group for outcome in outcomes), *(form.summary for form in forms)]
    tested = [outcome for outcome in every if outcome.analyses().keys() & {Primary.ANOVA, Primary.CENSORED}]
    models = [outcome.model for outcome in every if outcome.model is not None]
    titles = [outcome.title(outcome.primary) for outcome in every if outcome.primary is not None]
    tests_effects = any(form.tests_effects for form in forms)
    return paragraph(
        "group_methods.j2",
        has_intervals=any(table["mean_low"].notna().any() and not is_of_fit(table) for table in means),
        is_bounded=bool(forms) or any(outcome.dependent in RANGES for outcome in outcomes),
        fewest_in_range=FEWEST_IN_RANGE,
        has_within=any(table["within_low"].notna().any() for table in means),
        primary=list(dict.fromkeys(titles)),
        is_named=bool(named),
        rule=RULE,
        has_checks=any(len(outcome.analyses()) > 1 for outcome in every),
        is_corrected=tests_effects or any(outcome.within for outcome in tested),
        has_effects=tests_effects or bool(tested),
        has_censored=any(outcome.censored is not None for outcome in every),
        has_permutation=any(outcome.permutation is not None for outcome in every),
        **_comparisons(every, has_reference=any(form.against is not None for form in forms)),
        has_simple=any(outcome.simple or outcome.simple_pairs for outcome in every),
        has_model=any(not model.n_censored for model in models),
        has_censored_model=any(model.n_censored for model in models),
    )


def _comparisons(outcomes: Sequence[Outcome], *, has_reference: bool) -> dict[str, bool]:
    """Return True for each kind of comparison that was made."""
    censored = [outcome for outcome in outcomes if outcome.primary is Primary.CENSORED]
    others = [outcome for outcome in outcomes if outcome.primary is not Primary.CENSORED]
    return {
        "paired": has_reference or any(outcome.pairs for outcome in others),
        "grouped": any(outcome.group_pairs for outcome in others),
        "contrasted": any(outcome.pairs or outcome.group_pairs for outcome in censored),
    }
