"""An amplitude-modulated carrier: the force vibrates at a programmed frequency whatever the skin leaks."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactometry.arguments import require
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal

from ...arrays import FloatArray
from .level import LevelUnit, peak_voltage_v
from .pieces import Pieces, ramped as ramped_pieces
from .timing import check_nyquist, check_timing, ramped, times_s

Modulation = Literal["square_root", "full", "suppressed_carrier"]
FORCE_FREQUENCY_RATIO: Mapping[str, int] = {"square_root": 1, "full": 1, "suppressed_carrier": 2}

SIDEBANDS: Mapping[str, tuple[tuple[float, float], ...]] = {
    "square_root": ((0.5, 0.5), (-0.5, 0.5)),
    "full": ((0.0, 0.5), (1.0, 0.25), (-1.0, 0.25)),
    "suppressed_carrier": ((1.0, 0.5), (-1.0, 0.5)),
}


@dataclass(frozen=True)
class AmplitudeModulated:
    """``V0 m(t) sin(2 pi f_c t)``, ``c = cos(2 pi f t)``, f the programmed frequency, m by `modulation`:

    =====================  ======================  ============================================
    modulation             m(t)                    low-passed force in units of V0^2 (lossless)
    =====================  ======================  ============================================
    ``square_root``        ``sqrt((1 + c)/2)``     0.25 + 0.25 c: a pure tone at f
    ``full``               ``(1 + c)/2``           0.1875 + 0.25 c + 0.0625 cos(2 pi 2f t)
    ``suppressed_carrier`` ``c``                   0.25 + 0.25 cos(2 pi 2f t): a pure tone at 2f
    =====================  ======================  ============================================

    Parameters
    ----------
    frequency_hz : float
        Programmed frequency f, above 0.
    carrier_hz : float
        Carrier frequency f_c, at least ``2 f``, and its sideband ``f_c + f`` below half of `rate_hz`; 2 kHz is an
        unverified default.
    duration_s, ramp_s, rate_hz, level_unit
        As in `Sine`.
    modulation : {"square_root", "full", "suppressed_carrier"}
        The envelope.

    Raises
    ------
    InvalidParameter
        If a value is outside of its domain.

    >>> tone = AmplitudeModulated(frequency_hz=240.0)
    >>> tone.voltage_frequency_hz, tone.force_frequency_hz
    (2000.0, 240.0)
    >>> tone.at(14.0).samples.shape
    (1, 20000)
    """

    frequency_hz: float
    carrier_hz: float = 2_000.0
    duration_s: float = 1.0
    ramp_s: float = 0.05
    rate_hz: float = 20_000.0
    modulation: Modulation = "square_root"
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        owner = "AmplitudeModulated"
        require.positive(owner, frequency_hz=self.frequency_hz, carrier_hz=self.carrier_hz)
        require.one_of(f"{owner}.modulation", self.modulation, FORCE_FREQUENCY_RATIO)
        require.one_of(f"{owner}.level_unit", self.level_unit, ("dB re 1 V", "V"))
        check_timing(owner, self.duration_s, self.ramp_s, self.rate_hz)
        check_nyquist(owner, "carrier_hz", self.carrier_hz, self.rate_hz)
        check_nyquist(owner, "carrier_hz + frequency_hz", self.carrier_hz + self.frequency_hz, self.rate_hz)
        if self.carrier_hz < 2 * self.frequency_hz:
            raise InvalidParameter(
                f"{owner}.carrier_hz: found {self.carrier_hz} Hz, expected at least twice the programmed "
                f"frequency ({2 * self.frequency_hz} Hz); raise the carrier or lower frequency_hz"
            )

    @property
    def voltage_frequency_hz(self) -> float:
        return self.carrier_hz

    @property
    def force_frequency_hz(self) -> float:
        return FORCE_FREQUENCY_RATIO[self.modulation] * self.frequency_hz

    def at(self, level: float) -> Signal:
        """(1, n_samples) volt; no sample passes the peak that `level` states."""
        t_s = times_s(self.duration_s, self.rate_hz)
        shape = self._envelope(t_s) * np.sin(2 * np.pi * self.carrier_hz * t_s)
        samples = peak_voltage_v(level, self.level_unit) * ramped(shape, self.ramp_s, self.rate_hz)
        return Signal(samples[None, :], self.rate_hz, "V")

    def _envelope(self, t_s: FloatArray) -> FloatArray:
        cosine = np.cos(2 * np.pi * self.frequency_hz * t_s)
        if self.modulation == "suppressed_carrier":
            return cosine
        full = (1 + cosine) / 2
        return np.sqrt(full) if self.modulation == "square_root" else full

    def pieces(self, level: float) -> Pieces:
        """The voltage exactly, ramps included: ``sqrt((1 + c)/2) = |cos(pi f t)|`` changes sign from
        piece to piece."""
        starts_s: FloatArray = np.zeros(1)
        signs: FloatArray = np.ones(1)
        if self.modulation == "square_root":
            n_zeros = int(np.ceil(self.duration_s * self.frequency_hz - 0.5))
            starts_s = np.r_[0.0, (np.arange(n_zeros) + 0.5) / self.frequency_hz]
            signs = np.where(np.arange(n_zeros + 1) % 2, -1.0, 1.0)
        sidebands = SIDEBANDS[self.modulation]
        f_hz = np.array([self.carrier_hz + shift * self.frequency_hz for shift, _ in sidebands])
        c = -1j * peak_voltage_v(level, self.level_unit) * np.array([height for _, height in sidebands])
        zeros = np.zeros(len(starts_s))
        return ramped_pieces(Pieces(starts_s, self.duration_s, zeros, zeros, f_hz, signs[:, None] * c), self.ramp_s)
