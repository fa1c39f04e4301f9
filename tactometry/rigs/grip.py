"""The finger's force during one touch: collected, gated, and judged."""

import numpy as np
from numpy.typing import NDArray

from tactometry.devices.force_sensor import ForceSensor
from tactometry.force_gate import Compliance, ForceGate, compliance

SILENT_S = 0.1
"""A sensor that says nothing for longer is lost."""
AWAY_PART = 0.1
"""Below this part of the target the finger has left (unverified default)."""


class Grip:
    """Reads a sensor for one touch; older samples are dropped."""

    def __init__(self, sensor: ForceSensor, gate: ForceGate, now_s: float) -> None:
        sensor.read()
        self._sensor = sensor
        self._gate = gate
        self._times_s: list[float] = []
        self._forces_n: list[float] = []
        self._heard_s = now_s

    @property
    def open(self) -> bool:
        return self._gate.open

    @property
    def force_n(self) -> float | None:
        """The last force, N; None before the first sample and after a lost one."""
        return self._forces_n[-1] if self._forces_n and np.isfinite(self._forces_n[-1]) else None

    def read(self) -> None:
        """Take in what the sensor has collected."""
        times_s, forces_n = self._sensor.read()
        for time_s, force_n in zip(times_s.tolist(), forces_n.tolist(), strict=True):
            self._gate = self._gate.after(time_s, force_n)
        self._times_s += times_s.tolist()
        self._forces_n += forces_n.tolist()
        heard = times_s[np.isfinite(forces_n)]
        self._heard_s = max(self._heard_s, float(heard.max(initial=self._heard_s)))

    def silent(self, now_s: float) -> bool:
        """Whether the sensor says nothing."""
        return now_s - self._heard_s > SILENT_S

    def lost(self, now_s: float) -> bool:
        """Whether the sensor is silent, or the finger has left."""
        away = self.force_n is not None and self.force_n < AWAY_PART * self._gate.target_n
        return away or self.silent(now_s)

    def compliance(self, begin_s: float, end_s: float) -> Compliance | None:
        """How the force was kept from `begin_s` to `end_s`; None without samples or if stamps go back."""
        times_s, forces_n = self._between(begin_s, end_s)
        if times_s.size == 0 or np.any(np.diff(times_s) < 0):
            return None
        return compliance(times_s, forces_n, self._gate.target_n, self._gate.tolerance)

    def _between(self, begin_s: float, end_s: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        times_s, forces_n = np.array(self._times_s), np.array(self._forces_n)
        kept = (times_s >= begin_s) & (times_s <= end_s) & np.isfinite(forces_n)
        return times_s[kept], forces_n[kept]
