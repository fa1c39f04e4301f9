"""Columns of a trials table, in order."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from .tasks import TASKS
from .trial import REASONS


@dataclass(frozen=True)
class Column:
    """Name, meaning and unit (empty: none) of a column."""

    name: str
    description: str
    unit: str = ""


RIGS: Final = {
    "bench": "window",
    "console": "terminal",
    "simulated": "no person took part",
}
"""Rigs by name, with descriptions. The module `tactometry/rigs/NAME.py` contains a rig. The function NAME in
`experiments/sessions/rig_kinds.py` builds it."""
FIRST = (
    Column("participant", "Code of the participant"),
    Column("session", "Number of the session of this participant, from 1"),
    Column("study", "Name of the study"),
    Column("block", "Number of the block within the session, from 1"),
    Column("trial", "Number of the trial within the session, from 1; attempts of one trial share it"),
)
ALWAYS = (
    Column("procedure", "Rule that chose the level; in the rows of a questionnaire its name"),
    Column("level", "Level that was asked for; empty for a catch trial; of an adjustment the start"),
    Column("level_unit", "Unit of all levels"),
    Column("task", f"One of {', '.join(TASKS)}"),
    Column(
        "response",
        "1 or 0 for felt, different or stronger than the standard; the chosen interval or alternative; the number, the "
        "level that was set, or the raw value of an item as presented; empty: no answer",
    ),
    Column("correct", "1 correct, 0 wrong, empty: no answer or not defined"),
    Column("onset_s", "Onset of the (first) stimulus since the start of the session", "s"),
    Column("latency_s", "From the onset of the question to the answer", "s"),
    Column("force_mean_n", "Mean applied force during the stimulus", "N"),
    Column("force_sd_n", "Standard deviation of the applied force during the stimulus", "N"),
    Column("force_in_band", "Part (0 to 1) of the stimulus in which the running mean force was in the target band"),
    Column("valid", "1 valid, 0 not: the touch broke its conditions; such a trial is asked again"),
    Column("timestamp_utc", "Coordinated universal time of the answer, ISO 8601; empty in simulated time"),
)
OPTIONAL = (
    Column("track", "Interleaved procedure that the trial belongs to"),
    Column("attempt", "Number of the attempt at this trial, from 1"),
    Column("catch", "1: catch trial without stimulus (or with two standards), 0: not"),
    Column("item", "Item of a questionnaire, or first of a pair"),
    Column(
        "level_delivered", "Level that was delivered, in level_unit; empty for a catch trial and where nothing played"
    ),
    Column("level_measured", "Level that was measured, in level_unit"),
    Column("speed_target_m_per_s", "Target speed of the finger", "m/s"),
    Column("speed_mean_m_per_s", "Mean speed of the finger during the stimulus", "m/s"),
    Column("target", "Interval or alternative that held the stimulus, from 1"),
    Column("standard_level", "Level of the standard, in level_unit"),
    Column("item_b", "Second item of a pair"),
    Column("practice", "1: practice, 0: not"),
    Column("rig", f"What answered: {', '.join(f'{name} ({what})' for name, what in RIGS.items())}"),
    Column("speed_in_band", "Part (0 to 1) of the stimulus in which the speed was in the target band"),
    Column("invalid_reason", f"Why the trial is not valid: one of {', '.join(REASONS)}; empty: it is"),
    Column("n_gaps", "Gaps of the output during the stimuli of the trial; empty where the output cannot tell"),
    Column("positions_digest", "Digest of the finger's positions that a texture followed; empty in simulation"),
    Column("positions_late", "Part (0 to 1) of the stimulus in which positions came too late, and the last one held"),
    Column("separation_m", "Distance between the two places of the trial that are nearest to each other", "m"),
    Column("error_m", "Distance of the answered place from the right one", "m"),
)
FOREIGN = (
    Column("n_alternatives", "Number of intervals or alternatives of the choice; empty: the largest in its condition"),
)
"""Columns that tables of other programs may have."""
_DERIVED = (
    "source row yes is_catch x status threshold interval_low interval_high pse jnd width width_low width_high "
    "guess_rate lapse_rate n_yes n_trials n_levels n_catch n_false_alarms false_alarm_rate deviance method shape "
    "interval note mean mean_low mean_high within_low within_high sd n n_below n_above n_interval n_missing text rate "
    "rate_low rate_high n_rows n_practice n_invalid n_repeated n_unanswered score raw deviance_p residual_level_z "
    "residual_level_p residual_order_z residual_order_p dispersion dispersion_p misfit rule_estimate "
    "rule_sd rule_n rule_note threshold_mean threshold_median threshold_mode probability_below probability_above "
    "probability_within n_correct resolution_m "
    "resolution_m_low resolution_m_high right_place answered_place share_of_answers"
)
DERIVED = frozenset(_DERIVED.split())
"""Columns that an analysis adds."""
RESERVED = DERIVED | frozenset(column.name for column in (*FIRST, *ALWAYS, *OPTIONAL, *FOREIGN))
"""Names that no factor may have."""
MAY_BE_FACTORS = frozenset(
    ("session", "study", "block", "track", "item", "item_b", "procedure", "rig", "n_alternatives")
)
"""Reserved names that an analysis may use as factors on request."""


def table_columns(factors: Sequence[Column], optional: Sequence[str]) -> tuple[Column, ...]:
    """Return the columns of a study in order, with those named in `optional`."""
    return (*FIRST, *factors, *ALWAYS, *(column for column in OPTIONAL if column.name in optional))


def stated_factors(header: Sequence[str]) -> list[str]:
    """Return the columns between ``trial`` and ``procedure``: the factors."""
    if not {"trial", "procedure"} <= set(header):
        return []
    return list(header[header.index("trial") + 1 : header.index("procedure")])
