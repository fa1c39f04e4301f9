"""A time-reversal stimulus: a family of drives ordered by the unloaded amplitude of its focus."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from tactometry.arguments.checked import checked
from tactometry.arguments.require import one_of, positive, whole, within
from tactometry.errors import InvalidParameter, LimitExceeded
from tactometry.signal import Signal

from ..focusing.focusing import emitted
from ..focusing.pattern import (
    MODULATIONS,
    PATTERNS,
    Pattern,
    focus_samples,
    pattern_drive,
)
from ..focusing.quantiser import Quantiser
from ..responses.responses import Responses, samples_in

LEVEL_UNITS: Final = ("m", "dB re 1 um")
HIGHEST_LEVEL_DB: Final = 400.0


@checked
@dataclass(frozen=True, eq=False)
class TimeReversalStimulus:
    """Samples for every channel from the amplitude at the focus without a finger.

    Parameters
    ----------
    focus : Responses
        Of the model or measured, filtered; displacement. One point, or those that `path` visits.
    pattern : Pattern
        By default P0, one focus. The level is the largest focus of the pattern, overlaps included.
    quantiser : Quantiser, optional
        By default one bit.
    reversal_s : float, optional
        T, above 0; by default the whole of the responses.
    voltage_max_v : float
        What the amplifier can emit, above 0.
    level_unit : str
        ``m`` or ``dB re 1 um``.
    heard : Responses, optional
        What the focus points really do, unfiltered: the level is the amplitude there; by default `focus`.
    path : sequence of int, optional
        The row of each focus of the pattern, for a moving one, as in `pattern_drive`.
    modulation : str
        ``voltage`` or ``burst``, which needs `tau_s` (above 0).

    Examples
    --------
    >>> h = Responses(1e-9 * np.array([[[3.0, -2.0, 1.0]]]), 1e3)
    >>> stimulus = TimeReversalStimulus(h, level_unit="dB re 1 um")
    >>> stimulus.voltage_v(-20.0)
    16.66666...
    """

    focus: Responses
    pattern: Pattern = PATTERNS["P0"]
    quantiser: Quantiser | None = None
    reversal_s: float | None = None
    voltage_max_v: float = 30.0
    level_unit: str = "m"
    heard: Responses | None = None
    path: Sequence[int] | None = None
    modulation: str = "voltage"
    tau_s: float | None = None

    def __post_init__(self) -> None:
        one_of("TimeReversalStimulus.level_unit", self.level_unit, LEVEL_UNITS)
        one_of("TimeReversalStimulus.focus.quantity", self.focus.quantity, ("displacement",))
        positive("TimeReversalStimulus", voltage_max_v=self.voltage_max_v)
        one_of("TimeReversalStimulus.modulation", self.modulation, MODULATIONS)
        _check_heard(self)
        if self.reversal_s is not None:
            positive("TimeReversalStimulus", reversal_s=self.reversal_s)
            whole("TimeReversalStimulus", lowest=1, n_reversal=self._n_reversal)

    def at(self, level: float) -> Signal:
        """The drive (V) whose largest focus has this amplitude.

        Raises
        ------
        InvalidParameter
            If the amplitude is not above 0.
        LimitExceeded
            If it needs more than `voltage_max_v`.
        """
        voltage_v = self.voltage_v(level)
        if voltage_v > self.voltage_max_v * (1 + 1e-12):
            raise LimitExceeded(
                f"level: found {level} {self.level_unit}, which needs {voltage_v:.4g} V, above the "
                f"{self.voltage_max_v:.4g} V of the amplifier; the largest level is {self.level_max:.6g}"
            )
        return Signal(voltage_v * self._unit.samples, self._unit.rate_hz, "V")

    def voltage_v(self, level: float) -> float:
        """Peak voltage of a level, before anything is played."""
        amplitude_m = self._amplitude_m(level)
        positive("TimeReversalStimulus", level=amplitude_m)
        return amplitude_m / self.metres_per_volt

    @cached_property
    def metres_per_volt(self) -> float:
        """Amplitude of the largest focus per peak volt."""
        n = self.focus.n_samples if self.reversal_s is None else self._n_reversal
        instants = focus_samples(self.pattern, self.focus.rate_hz, n)
        rows = [0] * len(instants) if self.path is None else list(self.path)
        return float(np.abs(emitted(self._unit, self.heard or self.focus)[rows, instants]).max())

    @property
    def level_max(self) -> float:
        """The largest level within `voltage_max_v`."""
        amplitude_m = self.voltage_max_v * self.metres_per_volt
        return amplitude_m if self.level_unit == "m" else 20 * math.log10(amplitude_m / 1e-6)

    @cached_property
    def _unit(self) -> Signal:
        drive = pattern_drive(
            self.focus,
            self.pattern,
            1.0,
            self.quantiser,
            reversal_s=self.reversal_s,
            path=self.path,
            modulation=self.modulation,
            tau_s=self.tau_s,
        )
        return Signal(drive.samples / drive.peak, drive.rate_hz, "V")

    @property
    def _n_reversal(self) -> int:
        return samples_in("reversal_s", self.reversal_s or 0.0, self.focus.rate_hz)

    def _amplitude_m(self, level: float) -> float:
        if self.level_unit == "m":
            return level
        within("TimeReversalStimulus", -HIGHEST_LEVEL_DB, HIGHEST_LEVEL_DB, **{"level (dB re 1 um)": level})
        return 1e-6 * 10 ** (level / 20)


def _check_heard(stimulus: TimeReversalStimulus) -> None:
    heard = stimulus.heard
    if heard is not None and heard.samples.shape[:2] != stimulus.focus.samples.shape[:2]:
        raise InvalidParameter(
            f"TimeReversalStimulus.heard: found {heard.n_points} points and {heard.n_channels} channels, expected "
            f"{stimulus.focus.n_points} and {stimulus.focus.n_channels} as in focus"
        )
