"""Results for one dependent variable: primary analysis and checks.

The primary analysis is named in the plan. Otherwise a rule chooses it from the design and the missing values, never
from a result. The other analyses are checks under different assumptions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import pandas as pd

from ..anova.censored import CensoredAnova
from ..anova.design import DesignStatus
from ..mixed_models.linear import MixedModel
from ..tasks.kinds import RESULTS

FORCE = "force_n"
DIFFERENCES = ("jnd",)


class Primary(StrEnum):
    """Analyses that a plan may name as primary."""

    ANOVA = "anova"
    CENSORED = "censored_anova"
    PERMUTATION = "permutation"
    MIXED_MODEL = "mixed_model"


TITLES = {
    Primary.ANOVA: "analysis of variance",
    Primary.CENSORED: "analysis of variance with censored values",
    Primary.PERMUTATION: "permutation test",
    Primary.MIXED_MODEL: "linear mixed model",
}
RULE = (
    "an analysis of variance if every participant has a value in every condition, otherwise its maximum-likelihood "
    "version with the values and bounds of all participants"
)


@dataclass(frozen=True)
class Outcome:
    """Results for one dependent variable of one task.

    `primary` names the primary analysis, chosen for the `reason`. The others are checks: `anova` of the largest
    complete subset (without `left_out`) with `status` and tested assumptions (`checks`), `censored` of all values and
    bounds, a `permutation` test, and a mixed `model` of the measured force. `pairs`, `equivalence`, `group_pairs` (by
    factor), `simple` and `simple_pairs` (the first factor at each value of the second) belong to the primary analysis.
    A result that could not be computed is None; `notes` give the reason.
    """

    task: str
    dependent: str
    estimates: pd.DataFrame
    group: pd.DataFrame
    cross: pd.DataFrame
    within: tuple[str, ...] = ()
    between: str | None = None
    primary: Primary | None = None
    reason: str = ""
    notes: tuple[str, ...] = ()
    anova: pd.DataFrame | None = None
    left_out: tuple[str, ...] = ()
    status: DesignStatus | None = None
    checks: pd.DataFrame | None = None
    permutation: pd.DataFrame | None = None
    censored: CensoredAnova | None = None
    model: MixedModel | None = None
    model_title: str = ""
    pairs: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    equivalence: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    group_pairs: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    simple: Mapping[tuple[str, str], pd.DataFrame] = field(default_factory=dict)
    simple_pairs: Mapping[tuple[str, str], pd.DataFrame] = field(default_factory=dict)

    @property
    def factors(self) -> tuple[str, ...]:
        return tuple(self.group.columns[: self.group.columns.get_loc("mean")])

    def noted(self, *notes: str) -> "Outcome":
        """Return a copy with further notes."""
        return replace(self, notes=(*self.notes, *notes))

    def unit(self, of_levels: str) -> str:
        """Return the unit of the dependent variable."""
        if self.task in RESULTS and not RESULTS[self.task].in_levels:
            return ""
        return of_levels.partition(" re ")[0] if self.dependent in DIFFERENCES else of_levels

    @property
    def effects(self) -> pd.DataFrame | None:
        """Table of effects of the primary analysis."""
        return None if self.primary is None else self.analyses()[self.primary]

    def analyses(self) -> dict[Primary, pd.DataFrame]:
        """Return the tables of effects of all analyses that ran."""
        tables = {
            Primary.ANOVA: self.anova,
            Primary.CENSORED: None if self.censored is None or self.censored.table.empty else self.censored.table,
            Primary.PERMUTATION: self.permutation,
            Primary.MIXED_MODEL: None if self.model is None else self.model.terms,
        }
        return {name: table for name, table in tables.items() if table is not None}

    def title(self, name: Primary) -> str:
        """Return the title of an analysis."""
        # Without a within-participants factor, each participant has one value.
        kind = ("mixed" if self.within else "between-groups") if self.between else "repeated-measures"
        if name is Primary.ANOVA:
            which = f" of the largest complete subset, without {', '.join(self.left_out)}" if self.left_out else ""
            return f"{kind} {TITLES[name]}{which}"
        return {
            Primary.CENSORED: f"{kind} {TITLES[name]}",
            Primary.PERMUTATION: TITLES[name],
            Primary.MIXED_MODEL: f"{TITLES[name]}: {self.model_title}",
        }[name]

    def heading(self) -> str:
        """Return the heading of the primary analysis."""
        assert self.primary is not None
        return f"Primary analysis: {self.title(self.primary)} ({self.reason})"

    def tables(self, name: str) -> dict[str, pd.DataFrame]:
        """Return all tables by file name."""
        by_file: dict[str, pd.DataFrame | None] = {
            f"group_{name}": self.group,
            f"cross_{name}": self.cross,
            f"analyses_{name}": self.roles(),
            f"assumptions_{name}": self.checks,
        }
        by_file |= {f"{key}_{name}": table for key, table in self.analyses().items()}
        if self.model is not None:
            by_file |= {f"mixed_model_{name}": self.model.coefficients, f"mixed_model_terms_{name}": self.model.terms}
        for kind, tables in (("pairs", self.pairs), ("groups", self.group_pairs), ("equivalence", self.equivalence)):
            by_file |= {f"{kind}_{name}_{factor}": table for factor, table in tables.items()}
        for kind, simple in (("simple", self.simple), ("pairs", self.simple_pairs)):
            by_file |= {f"{kind}_{name}_{factor}_by_{by}": table for (factor, by), table in simple.items()}
        return {key: table for key, table in by_file.items() if table is not None and len(table)}

    def roles(self) -> pd.DataFrame:
        """Return the table of analyses that marks the primary one and the checks."""
        rows = []
        for name in self.analyses():
            role, reason = ("primary", self.reason) if name is self.primary else ("check", "")
            rows.append({"role": role, "analysis": name.value, "title": self.title(name), "reason": reason})
        return pd.DataFrame(rows)


def primary_analysis(
    named: str | None, *, is_whole: bool, between: str | None = None, within: Sequence[str] = ()
) -> tuple[Primary, str]:
    """Return the primary analysis and the reason for it.

    >>> primary_analysis(None, is_whole=False)
    (<Primary.CENSORED: 'censored_anova'>, 'by default: values are missing or censored')
    >>> primary_analysis(None, is_whole=True, between="group")[1]
    'by default: every participant has a value, and group differs between participants'
    >>> primary_analysis("permutation", is_whole=True)
    (<Primary.PERMUTATION: 'permutation'>, 'named in the analysis plan')
    """
    if named is not None:
        return Primary(named), "named in the analysis plan"
    if is_whole:
        where = " in every condition" if within or between is None else ""
        groups = "" if between is None else f", and {between} differs between participants"
        return Primary.ANOVA, f"by default: every participant has a value{where}{groups}"
    return Primary.CENSORED, "by default: values are missing or censored"
