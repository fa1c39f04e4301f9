"""Sensation level of the strongest focus under a finger."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ...composition.effect import Effect, Stage, Surroundings, note
from ...defaults import FOCUS_AT_THRESHOLD_M
from ..stages.truncation import is_away

if TYPE_CHECKING:
    from ...arrays import FloatArray


@dataclass(frozen=True)
class FocusDetection(Effect):
    """Sensation level of a focus, relative to a threshold of `reference_m`.

    It is computed as in `tactometry.stimuli.time_reversal.TimeReversalSensation`, at the first resting finger, by
    default at the focus. The finger loads the plate only with `finger_load`. 10 um are the thesis's.

    Parameters
    ----------
    reference_m : float
        Peak displacement of a single focus at the detection threshold.
    """

    kind = "focus_detection"
    slot = "detection"
    positive = ("reference_m",)
    reads, gives = ("felt_at_1v_m", "voltage_v"), "sensation_db"
    cures = note("add the effect focus_detection", "sensation_db")
    assumes = ("every focus is felt as one event of displacement, at any course; a train by its energy in 0.2 s",)
    rests_on = "the amplitude of a single focus at threshold (calibrated: 10 um is the thesis's value)"

    reference_m: float = FOCUS_AT_THRESHOLD_M

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        loaded = scene.find("load") is not None
        free = "per_volt_finger" if is_away(scene) else "per_volt_course"
        needs = ("t_s", "per_volt_contacts" if loaded else free)
        target = f"{__name__}:{'under_finger' if loaded else 'single_event_m_per_v'}"
        return Stage("events", needs, "felt_at_1v_m", target), self.stage()

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return the stages for displacements under fingers by a played signal."""
        events = Stage("events", ("t_s", "displacement_m"), "felt_m", f"{__name__}:single_events_m")
        return events, replace(self.stage(), needs=("felt_m",))

    def __call__(self, felt_at_1v_m: "float | FloatArray", voltage_v: float = 1.0) -> "float | FloatArray":
        """Return the level above threshold per finger; ``-inf`` for silence."""
        import numpy as np

        with np.errstate(divide="ignore"):
            level_db: float | FloatArray = 20 * np.log10(felt_at_1v_m * abs(voltage_v) / self.reference_m)
        return level_db


def single_event_m_per_v(t_s: "FloatArray", course: "FloatArray") -> float:
    """Return the amplitude (m/V) of the single event equivalent to a course."""
    from ...time_reversal.stimulus.sensation import events, felt_amplitude_m

    times_s, peaks = events(course, 1 / float(t_s[1] - t_s[0]))
    return felt_amplitude_m(times_s, peaks) if peaks.size else 0.0


def under_finger(t_s: "FloatArray", courses: "FloatArray") -> float:
    """Return the event amplitude per volt at the first finger."""
    return single_event_m_per_v(t_s, courses[0])


def single_events_m(t_s: "FloatArray", courses_m: "FloatArray") -> "FloatArray":
    """Return the equivalent event amplitude (m) of each finger, (n_fingers,)."""
    import numpy as np

    return np.array([single_event_m_per_v(t_s, course_m) for course_m in courses_m])
