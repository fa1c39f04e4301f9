"""A constant added to a voltage."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from tactometry.arguments.checked import checked
from tactometry.signal import Signal

from ..skin.skin import Skin
from ..waveforms.pieces import Pieces, ramped as ramped_pieces
from ..waveforms.waveform import LevelUnit, Waveform, peak_voltage_v, ramped
from .force import Law, force_form


@checked
@dataclass(frozen=True)
class WithOffset:
    """A waveform w of peak V0 plus a constant: ``(w + ratio V0)/(1 + |ratio|)``, again of peak V0.

    In a lossless skin the force then contains the frequency of the voltage. A leaky corneum behind an insulator
    discharges within a few time constants: the force of the constant vanishes in the `sc_layer` law and rises in the
    `interface` law. `remark` reports this. The constant has the ramps of w.

    Parameters
    ----------
    waveform
        Any waveform of this package.
    ratio : float
        Constant divided by the peak of the waveform, of either sign.

    >>> from tactometry.stimuli.electrovibration import Sine
    >>> tone = WithOffset(Sine(frequency_hz=60.0), ratio=0.5)
    >>> tone.at(20.0).peak <= 10.0, tone.force_frequency_hz
    (True, 60.0)
    """

    waveform: Waveform
    ratio: float

    @property
    def level_unit(self) -> LevelUnit:
        return self.waveform.level_unit

    @property
    def voltage_frequency_hz(self) -> float:
        return self.waveform.voltage_frequency_hz

    @property
    def force_frequency_hz(self) -> float:
        """The lower of the waveform's force and voltage frequencies."""
        own_hz = self.waveform.force_frequency_hz
        return own_hz if self.ratio == 0 else min(own_hz, self.voltage_frequency_hz)

    def at(self, level: float) -> Signal:
        """Return samples (1, n_samples) in volt, at most the peak of `level`."""
        signal = self.waveform.at(level)
        constant = ramped(np.ones(signal.samples.shape[1]), self.waveform.ramp_s, signal.rate_hz)
        peak_v = peak_voltage_v(level, self.level_unit)
        share = 1 / (1 + abs(self.ratio))
        total_v = share * signal.samples + self.ratio * share * peak_v * constant
        # rounding may raise the sum of two parts above the stated peak by one digit
        return Signal(np.clip(total_v, -peak_v, peak_v), signal.rate_hz, "V")

    def pieces(self, level: float) -> Pieces:
        """Return the exact voltage."""
        plain = self.waveform.pieces(level)
        constant = Pieces(np.zeros(1), plain.end_s, np.ones(1), np.zeros(1))
        constant = ramped_pieces(constant, self.waveform.ramp_s)
        share, peak_v = 1 / (1 + abs(self.ratio)), peak_voltage_v(level, self.level_unit)
        return _sum(plain.scaled(share), constant.scaled(self.ratio * share * peak_v))

    def remark(self, skin: Skin, law: Law, area_m2: float = 1e-4) -> str | None:
        """Describe how the skin changes the offset's force, or return None.

        The remark states the time of the law's slowest relaxation on the contact area (1 cm^2: unverified default).

        >>> from tactometry.stimuli.electrovibration import Sine
        >>> tone = WithOffset(Sine(frequency_hz=60.0), ratio=0.5)
        >>> tone.remark(Skin(), "sc_layer")
        "WithOffset.ratio: sc_layer leaves less than 1 % of the offset's force 5 tau (1.58 ms) after its last change"
        >>> tone.remark(Skin(), "interface")
        "WithOffset.ratio: interface yields the offset's full force 5 tau (1.58 ms) after its last change"
        >>> tone.remark(Skin(), "parallel_plate") is None
        True
        """
        relaxations = force_form(law, skin, area_m2).relaxations
        keeps = relaxations.dc_gain != 0
        if self.ratio == 0 or (keeps and not relaxations.rates_per_s):
            return None
        fate = "yields the offset's full force" if keeps else "leaves less than 1 % of the offset's force"
        after_ms = 5e3 / min(relaxations.rates_per_s, default=inf)
        return f"WithOffset.ratio: {law} {fate} 5 tau ({after_ms:.3g} ms) after its last change"


def _sum(one: Pieces, other: Pieces) -> Pieces:
    # split each at the starts of both, so that they add piece by piece
    one, other = one.split_at(other.starts_s), other.split_at(one.starts_s)
    return replace(
        one,
        offsets_v=one.offsets_v + other.offsets_v,
        slopes_v_per_s=one.slopes_v_per_s + other.slopes_v_per_s,
        frequencies_hz=np.r_[one.frequencies_hz, other.frequencies_hz],
        amplitudes_v=np.hstack([one.harmonics_v, other.harmonics_v]),
    )
