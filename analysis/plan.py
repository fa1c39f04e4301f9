"""Analysis plan, written before data are seen."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from tactometry.arguments.require import expect
from tactometry.config.quantity import as_si
from tactometry.config.strict import build, read_toml
from tactometry.errors import nearest

from .reading.origin import study_table
from .reading.quality import Exclusion


@dataclass(frozen=True)
class AnalysisPlan:
    """Exclusions, equivalence bounds and primary analysis.

    - `exclusion`: Rules that exclude trials and participants.
    - `equivalence`: Largest negligible difference between the levels of a factor, in the unit of the threshold.
    - `hierarchical`: Also fits a hierarchical model of all participants.
    - `primary`: Name of the primary analysis; the others are checks. By default a rule chooses it.

    Raises
    ------
    InvalidParameter
        If a bound is not above 0.

    >>> AnalysisPlan(equivalence={"force_n": 1.0}).equivalence
    {'force_n': 1.0}
    """

    exclusion: Exclusion = field(default_factory=Exclusion)
    equivalence: dict[str, float] = field(default_factory=dict)
    hierarchical: bool = True
    primary: Literal["anova", "censored_anova", "permutation", "mixed_model"] | None = None

    def __post_init__(self) -> None:
        for name, bound in self.equivalence.items():
            expect(np.isfinite(bound) and bound > 0, f"equivalence.{name}", bound, "a difference above 0")

    def check(self, factors: Sequence[str]) -> None:
        """Raise for an equivalence bound of an unknown factor."""
        for name in self.equivalence:
            expected = f"one of {', '.join(factors)}{nearest(name, factors)}"
            expect(name in factors, f"equivalence.{name}", "no such factor", expected)


def read_plan(path: str | Path) -> AnalysisPlan:
    """Read a plan from TOML tables `[exclusion]` and `[equivalence]`.

    Raises `InvalidFile` if the file cannot be read, or contains unknown keys.
    """
    return read_toml(AnalysisPlan, Path(path), "an analysis plan")


def plan_of(path: Path) -> AnalysisPlan:
    """Return the plan in `[analysis]` of a study, or an empty plan.

    Raises `InvalidFile` if the study cannot be read, or its table contains unknown keys.
    """
    return study_table(path, "analysis", lambda table: build(AnalysisPlan, as_si(dict(table), "analysis"), "analysis"))
