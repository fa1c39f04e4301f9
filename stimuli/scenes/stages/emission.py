"""Emission of the transducers: learning, reversal and quantisation."""

from dataclasses import dataclass, replace

import numpy as np

from tactometry.signal import Signal

from ...arrays import FloatArray
from ...time_reversal.filters import Band, Butterworth, GainCurve, filtered
from ...time_reversal.focusing.focusing import Emission, reversed_waveform
from ...time_reversal.focusing.quantiser import Analogue, Quantiser
from ...time_reversal.plate.glass import GLASSES
from ...time_reversal.plate.modes import Modes
from ...time_reversal.plate.plate import Plate
from ...time_reversal.responses import responses
from ...time_reversal.responses.responses import Responses
from ...time_reversal.screen.attenuation import Attenuation
from ...time_reversal.screen.screen import Screen, warmed
from ...time_reversal.screen.transducer import ForceSource, PointForce, border

Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False)
class EmittedSignal:
    """Samples (n_channels, n_samples) of the transducers per volt of peak; the focus is at sample `focus`."""

    samples: FloatArray
    rate_hz: float
    focus: int

    @property
    def at_1_v(self) -> Signal:
        return Signal(self.samples, self.rate_hz, "V")


@dataclass(frozen=True)
class Push:
    """A point force proportional to a voltage."""

    point: PointForce
    force_n_per_v: float

    def modal_force(self, modes: Modes) -> FloatArray:
        return self.force_n_per_v * self.point.modal_force(modes)

    def check(self, plate: Plate, name: str) -> None:
        self.point.check(plate, name)


def glass_plate(glass: str, length_m: float, width_m: float, thickness_m: float) -> Plate:
    return GLASSES[glass].plate(length_m, width_m, thickness_m, "SSSS")


def pushes(plate: Plate, n_transducers: int, inset_m: float, force_n_per_v: float) -> tuple[ForceSource, ...]:
    """Return point forces along the border."""
    places = border(plate, n_transducers, inset_m, inset_m)
    return tuple(Push(PointForce(place.x_m, place.y_m), force_n_per_v) for place in places)


def patches(
    plate: Plate, n_transducers: int, inset_m: float, side_m: float, moment_n_per_v: float
) -> tuple[ForceSource, ...]:
    """Return patches along the border."""
    return tuple(border(plate, n_transducers, side_m, inset_m, moment_n_per_v))


def lossless(plate: Plate, sources: tuple[ForceSource, ...]) -> Screen:
    return Screen(plate, sources, Attenuation(float("inf")))


def single(x_m: float, y_m: float) -> Points:
    """Return one focus."""
    return ((x_m, y_m),)


def several(x_m: tuple[float, ...], y_m: tuple[float, ...]) -> Points:
    """Return several foci."""
    return tuple(zip(x_m, y_m, strict=True))


def learning(
    screen: Screen, foci: Points, rate_hz: float, reversal_s: float, f_max_hz: float, flank_hz: float
) -> Responses:
    """Return responses at the foci, of the modes in the band, of length T."""
    band = Band(0.0, f_max_hz, flank_hz)
    return Emission(band, reversal_s, rate_hz, modes_to_hz=f_max_hz).responses(screen, foci)


def learning_colder(screen: Screen, foci: Points, kelvin: float, shift_per_k: float, **learnt: float) -> Responses:
    """Return the responses learnt on the colder plate."""
    return learning(warmed(screen, -kelvin, shift_per_k), foci, **learnt)


def analogue() -> Quantiser:
    return Analogue()


def amplified_responses(learnt: Responses, cutoff_hz: float, order: int) -> Responses:
    """Return the responses of amplifier and plate in series."""
    return responses.through(learnt, Butterworth(cutoff_hz, order))


def amplified(emission: EmittedSignal, cutoff_hz: float, order: int) -> EmittedSignal:
    """Apply the low pass of the amplifier."""
    return through(emission, Butterworth(cutoff_hz, order))


def emit(learnt: Responses, rule: Quantiser) -> EmittedSignal:
    """Reverse and quantise the learnt responses for the amplifier."""
    waveform = reversed_waveform(learnt)
    return EmittedSignal(rule.quantise(waveform, learnt.rate_hz), learnt.rate_hz, waveform.shape[1] - 1)


def in_band(emission: EmittedSignal, f_max_hz: float, flank_hz: float, margin_s: float) -> EmittedSignal:
    """Return the emission in the band at zero phase, `margin_s` longer."""
    wide = through(emission, Band(0.0, f_max_hz, flank_hz), margin_s)
    rise = np.sin(np.linspace(0, np.pi / 2, round(margin_s * emission.rate_hz))) ** 2
    flat = np.ones(emission.samples.shape[1])
    return replace(wide, samples=wide.samples * np.concatenate([rise, flat, rise[::-1]]))


def through(emission: EmittedSignal, gain: GainCurve, margin_s: float = 0.0) -> EmittedSignal:
    """Filter an emission by a linear element."""
    margin = round(margin_s * emission.rate_hz)
    wide = np.pad(emission.samples, ((0, 0), (margin, margin)))
    return replace(emission, samples=filtered(wide, emission.rate_hz, gain), focus=emission.focus + margin)
