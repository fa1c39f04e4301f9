"""Table 6.2, figures 6.12 and 6.13: how simulated fingers kept the forces that a study asks for."""

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from tactometry.observers.finger import SimulatedFinger

from ..reproduction import Number, Reproduction
from .studies import simulated_trials

if TYPE_CHECKING:
    import pandas as pd

STUDY, N_PARTICIPANTS = "electrovibration-threshold", 4
FORCE = "force_n"
BETWEEN, WITHIN = 100 * SimulatedFinger.force_cv, 100 * SimulatedFinger.waver_cv
ASSUMES = (
    f"{N_PARTICIPANTS} simulated participants of the built-in study {STUDY} with seed 1. Its forces are unverified "
    f"defaults, and so is the finger: its mean force differs from trial to trial by {BETWEEN:g} %, drawn anew outside "
    f"of the 20 % that open the gate, and wavers by {WITHIN:g} % within a trial. No simulation can tell how people "
    "pressed."
)


@lru_cache(maxsize=1)
def touches() -> "pd.DataFrame":
    """The trials that are used, each with its mean applied force."""
    from tactometry.analysis.reading.trials import used_rows

    return used_rows(simulated_trials(STUDY, N_PARTICIPANTS))


def _means() -> Iterator[Number]:
    from tactometry.analysis.tasks.applied_force import force_of_participants, force_table

    for row in force_table(force_of_participants(touches(), [FORCE]), [FORCE]).to_dict("records"):
        condition = f"condition of {row[FORCE]:g} N"
        yield Number("asked", condition, row[FORCE], "N", "assumed")
        yield Number("mean applied force", condition, row["mean"], "N", "assumed")
        yield Number("SD between participants", condition, row["sd"], "N", "assumed")
        yield Number("time in the band", condition, 100 * row["in_band"], "%", "assumed")


def _mean_by_condition() -> Any:
    from tactometry.analysis.figures.psychophysics import threshold_figure
    from tactometry.analysis.tasks.applied_force import force_of_participants, force_table

    factors = [FORCE, "frequency_hz"]
    individuals = force_of_participants(touches(), factors)
    targets = sorted(set(individuals[FORCE]))
    values = force_table(individuals, factors), individuals, factors, "force_mean_n"
    return threshold_figure(*values, "Mean applied force (N)", targets=targets, from_zero=True).figure


def _measured() -> Any:
    from ..figures.perception import applied_forces

    by_force = touches().groupby(FORCE)["force_mean_n"]
    return applied_forces({float(str(asked)): list(forces) for asked, forces in by_force})


TABLE_6_2 = Reproduction(
    title="Mean applied force of each condition",
    stated="That there were three forces, shown to the participant (pages 14 and 16); their values are not in "
    "our sources.",
    assumes=ASSUMES,
    numbers=_means,
)
FIGURE_6_12 = Reproduction(
    title="Mean applied force of each condition, by frequency",
    stated="The caption of Figure 6.12 (page 14); not the values.",
    assumes=ASSUMES,
    drawing=_mean_by_condition,
    origin="assumed",
)
FIGURE_6_13 = Reproduction(
    title="Applied force of each trial, by condition",
    stated="The caption of Figure 6.13 (page 14); not the values.",
    assumes=ASSUMES,
    drawing=_measured,
    origin="assumed",
)
