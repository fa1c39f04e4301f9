"""Every kind of change during a session, by the name that a study file uses, imported when it is named."""

from typing import Final

CHANGES: Final = {
    "learning": f"{__package__}.learning:SlowLearning",
    "fatigue": f"{__package__}.fatigue:Fatigue",
    "lapses_in_runs": f"{__package__}.lapses_in_runs:LapsesInRuns",
    "criterion_drift": f"{__package__}.criterion_drift:CriterionDrift",
    "serial_dependence": f"{__package__}.serial_dependence:SerialDependence",
}
