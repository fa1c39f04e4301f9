"""The finger's force during one touch: collected, gated, and judged."""

import math

from ...devices.sensors.reader import FloatArray
from ...gates.force import Compliance, ForceGate, compliance
from ...safety.limits import FORCE_PEAK_N
from ...trials.trial import Reason
from .trace import Since, Trace

SILENT_S = 0.1
"""A sensor that says nothing for longer is lost."""
AWAY_PART = 0.1
"""Below this part of the target the finger has left (unverified default)."""


class AppliedForce:
    """Hears the samples of one touch; `opened_s` is the stamp of the sample that opened the gate.

    A force above `force_peak_n` stops what plays.
    """

    def __init__(self, gate: ForceGate, force_peak_n: float = FORCE_PEAK_N) -> None:
        self._gate, self._force_peak_n = gate, force_peak_n
        self._trace, self._since = Trace(), Since()
        self._known_s: float | None = None
        self.opened_s: float | None = None
        self.force_n: float | None = None
        """The last force, N; None before the first sample and after a lost one."""

    @property
    def open(self) -> bool:
        """Whether the force was held long enough, by the sensor's stamps and by our clock, and is known of now."""
        return self._gate.open and self._since.lasts(self._gate.hold_s) and self._trace.age_s <= SILENT_S

    @property
    def gate(self) -> ForceGate:
        """The gate after the last sample."""
        return self._gate

    def hear(self, times_s: FloatArray, forces_n: FloatArray) -> None:
        self._trace.hear(times_s, forces_n)
        for time_s, force_n in zip(times_s.tolist(), forces_n.tolist(), strict=True):
            was_open = self._gate.open
            self._gate = self._gate.after(time_s, force_n)
            self._since.hear(self._gate.since_s)
            if self._gate.open and not was_open:
                self.opened_s = time_s
            self.force_n = force_n if math.isfinite(force_n) else None
            if self._known_s is None or self.force_n is not None:
                self._known_s = time_s  # of a first sample that is lost too: from there on the silence counts

    @property
    def silent(self) -> bool:
        """Whether the sensor says nothing, or nothing but lost samples."""
        last_s, known_s = self._trace.last_s, self._known_s
        lost = last_s is not None and known_s is not None and last_s - known_s > SILENT_S
        return lost or self._trace.quiet(SILENT_S)

    @property
    def loss(self) -> Reason | None:
        """Why nothing may play any more: the sensor is silent, the finger has left, or it presses too much."""
        force_n = self.force_n
        if self.silent:
            return "sensor_lost"
        if force_n is None:
            return None
        if force_n > self._force_peak_n:
            return "too_heavy"
        return "lifted" if force_n < AWAY_PART * self._gate.target_n else None

    def compliance(self, begin_s: float, end_s: float) -> Compliance | None:
        """How the force was kept from `begin_s` to `end_s`; None without samples or if stamps go back."""
        times_s, forces_n = self._trace.between(begin_s, end_s)
        if times_s.size == 0:
            return None
        return compliance(times_s, forces_n, self._gate.target_n, self._gate.tolerance)
