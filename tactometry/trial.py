"""One row of the trials table."""

from collections.abc import Mapping
from dataclasses import dataclass, field

Value = str | int | float | bool | None


@dataclass(frozen=True)
class Trial:
    """What one trial asked, and what came back; `None` means not measured (an empty cell).

    `factors` keep their names and order of the study file. Times are seconds since the start of the session on the
    rig's monotonic clock; `timestamp_utc` is ISO 8601, empty for a rig that lives in simulated time.
    """

    block: int
    trial: int
    factors: Mapping[str, float | str]
    procedure: str
    level: float | None
    level_unit: str
    task: str
    response: float | str | None
    correct: bool | None = None
    onset_s: float | None = None
    latency_s: float | None = None
    force_mean_n: float | None = None
    force_sd_n: float | None = None
    force_in_band: float | None = None
    valid: bool = True
    timestamp_utc: str | None = None
    track: str | None = None
    attempt: int = 1
    catch: bool | None = None
    item: str | None = None
    level_delivered: float | None = None
    level_measured: float | None = None
    speed_target_m_per_s: float | None = None
    speed_mean_m_per_s: float | None = None
    target: int | None = None
    standard_level: float | None = None
    item_b: str | None = None
    practice: bool | None = None
    extra: Mapping[str, Value] = field(default_factory=dict)
