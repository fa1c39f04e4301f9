"""From a plate to what its transducers emit: learn, reverse, quantise."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tactometry.signal import Signal

from ...arrays import FloatArray
from ...time_reversal.filters import Band, GainCurve, filtered
from ...time_reversal.focusing.focusing import Emission, reversed_waveform
from ...time_reversal.focusing.quantiser import Analogue, Quantiser
from ...time_reversal.plate.modes import Modes
from ...time_reversal.plate.plate import Plate
from ...time_reversal.responses.responses import Responses
from ...time_reversal.screen.attenuation import Attenuation
from ...time_reversal.screen.screen import Screen
from ...time_reversal.screen.transducer import ForceSource, PointForce, border

Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False)
class EmittedSignal:
    """Samples (n_channels, n_samples) of the transducers per volt of peak; the focus comes at sample `focus`."""

    samples: FloatArray
    rate_hz: float
    focus: int

    @property
    def at_1_v(self) -> Signal:
        return Signal(self.samples, self.rate_hz, "V")


@dataclass(frozen=True)
class Push:
    """A force at a point in proportion to a voltage."""

    point: PointForce
    force_n_per_v: float

    def modal_force(self, modes: Modes) -> FloatArray:
        return self.force_n_per_v * self.point.modal_force(modes)

    def check(self, plate: Plate, name: str) -> None:
        self.point.check(plate, name)


def glass_plate(glass: str, length_m: float, width_m: float, thickness_m: float) -> Callable[[], Plate]:
    """A plate of a glass, its edges simply supported."""
    from ...time_reversal.plate.glass import GLASSES

    plate = GLASSES[glass].plate(length_m, width_m, thickness_m, "SSSS")
    return lambda: plate


def pushes(n_transducers: int, inset_m: float, force_n_per_v: float) -> Callable[[Plate], tuple[ForceSource, ...]]:
    """Points along the border."""

    def placed(plate: Plate) -> tuple[ForceSource, ...]:
        places = border(plate, n_transducers, inset_m, inset_m)
        return tuple(Push(PointForce(place.x_m, place.y_m), force_n_per_v) for place in places)

    return placed


def lossless() -> Callable[[Plate, tuple[ForceSource, ...]], Screen]:
    """A plate with transducers that rings for ever."""
    return lambda plate, sources: Screen(plate, sources, Attenuation(float("inf")))


def single(x_m: float, y_m: float) -> Callable[[], Points]:
    """One place to focus on."""
    return lambda: ((x_m, y_m),)


def learning(
    rate_hz: float, reversal_s: float, band_max_hz: float, flank_hz: float
) -> Callable[[Screen, Points], Responses]:
    """What the transducers do at the foci: the modes of the band, over the reversal time."""
    band = Band(0.0, band_max_hz, flank_hz)
    return Emission(band, reversal_s, rate_hz, modes_to_hz=band_max_hz).responses


def analogue() -> Callable[[], Quantiser]:
    """A linear amplifier."""
    return Analogue


def quantised() -> Callable[[Responses, Quantiser], EmittedSignal]:
    """The learnt responses, reversed, as the amplifier can emit them."""

    def played(learnt: Responses, rule: Quantiser) -> EmittedSignal:
        waveform = reversed_waveform(learnt)
        return EmittedSignal(rule.quantise(waveform, learnt.rate_hz), learnt.rate_hz, waveform.shape[1] - 1)

    return played


def in_band(band_max_hz: float, flank_hz: float, margin_s: float) -> Callable[[EmittedSignal], EmittedSignal]:
    """What of an emission lies in the band, without a change of phase; what rings outside fades over `margin_s`."""
    band = Band(0.0, band_max_hz, flank_hz)

    def limited(emission: EmittedSignal) -> EmittedSignal:
        wide = through(emission, band, margin_s)
        rise = np.sin(np.linspace(0, np.pi / 2, round(margin_s * emission.rate_hz))) ** 2
        flat = np.ones(emission.samples.shape[1])
        return replace(wide, samples=wide.samples * np.concatenate([rise, flat, rise[::-1]]))

    return limited


def through(emission: EmittedSignal, gain: GainCurve, margin_s: float = 0.0) -> EmittedSignal:
    """An emission behind a linear element."""
    margin = round(margin_s * emission.rate_hz)
    wide = np.pad(emission.samples, ((0, 0), (margin, margin)))
    return replace(emission, samples=filtered(wide, emission.rate_hz, gain), focus=emission.focus + margin)
