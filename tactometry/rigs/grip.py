"""The finger's force during one touch: collected, gated, and judged."""

import numpy as np

from tactometry.devices.reader import FloatArray
from tactometry.force_gate import Compliance, ForceGate, compliance
from tactometry.rigs.trace import Trace

SILENT_S = 0.1
"""A sensor that says nothing for longer is lost."""
AWAY_PART = 0.1
"""Below this part of the target the finger has left (unverified default)."""


class Grip:
    """Hears the samples of one touch, from `now_s` on; `opened_s` is the stamp of the sample that opened the gate."""

    def __init__(self, gate: ForceGate, now_s: float) -> None:
        self._gate = gate
        self._trace = Trace()
        self._heard_s = self._expected_s = now_s
        self.opened_s: float | None = None
        self.force_n: float | None = None
        """The last force, N; None before the first sample and after a lost one."""

    @property
    def open(self) -> bool:
        return self._gate.open

    def hear(self, times_s: FloatArray, forces_n: FloatArray) -> None:
        self._trace.hear(times_s, forces_n)
        for time_s, force_n in zip(times_s.tolist(), forces_n.tolist(), strict=True):
            was_open, self._gate = self._gate.open, self._gate.after(time_s, force_n)
            self.opened_s = time_s if self._gate.open and not was_open else self.opened_s
            self.force_n = force_n if np.isfinite(force_n) else None
        heard = times_s[np.isfinite(forces_n)]
        self._heard_s = max(self._heard_s, float(heard.max(initial=self._heard_s)))

    def excuse(self, now_s: float) -> None:
        """Silence counts from now: the thread that listens was held up."""
        self._expected_s = now_s

    def silent(self, now_s: float) -> bool:
        """Whether the sensor says nothing."""
        return now_s - max(self._heard_s, self._expected_s) > SILENT_S

    def lost(self, now_s: float) -> bool:
        """Whether the sensor is silent, or the finger has left."""
        force_n = self.force_n
        return (force_n is not None and force_n < AWAY_PART * self._gate.target_n) or self.silent(now_s)

    def compliance(self, begin_s: float, end_s: float) -> Compliance | None:
        """How the force was kept from `begin_s` to `end_s`; None without samples or if stamps go back."""
        times_s, forces_n = self._trace.between(begin_s, end_s)
        if times_s.size == 0:
            return None
        return compliance(times_s, forces_n, self._gate.target_n, self._gate.tolerance)
