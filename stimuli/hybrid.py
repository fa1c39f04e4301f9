"""Stimuli of foci and electrovibration of a sliding finger on one screen.

Proposed in the outlook of Zophoniasson's thesis (2017): dynamic and static feedback on one surface.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from tactometry.arguments.require import expect, finite, positive
from tactometry.signal import Signal

from .defaults import FOCUS_AT_THRESHOLD_M
from .electrovibration.sensation import ElectrovibrationSensation
from .electrovibration.waveforms.amplitude_modulated import AmplitudeModulated, pulses
from .time_reversal.responses.responses import Responses
from .time_reversal.stimulus import focus_train
from .time_reversal.stimulus.focus_train import FocusTrain, TimeReversalStimulus
from .time_reversal.stimulus.setup import Setup


@dataclass(frozen=True)
class Hybrid:
    """Foci and friction with a common onset; the level is that of the foci.

    The channels are those of the transducers, then that of the electrode. The electrode's level (dB re 1 V) is the
    level of the foci (dB re 1 um) plus `electrode_offset_db`, so that both grow together.

    Raises `InvalidParameter` if a value is not as stated.

    Parameters
    ----------
    focus : FocusTrain
        Foci with the level in dB re 1 um. A `supply_v` also makes the friction, by pulse width.
    friction : AmplitudeModulated
        Friction with the level in dB re 1 V, the rate of the screen (`focus.setup.rate_hz`) and the duration of the
        foci.
    electrode_offset_db : float
        Level of the electrode minus that of the foci; 12 dB is a choice, at which both are felt.

    >>> setup = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3)
    >>> focus = FocusTrain(setup, f_max_hz=20e3)
    >>> both = Hybrid(focus, AmplitudeModulated(frequency_hz=120.0, duration_s=0.5, rate_hz=50e3))
    >>> both.at(20.0).samples.shape, both.level_unit
    ((9, 25000), 'dB re 1 um')
    """

    focus: FocusTrain
    friction: AmplitudeModulated
    electrode_offset_db: float = 12.0

    def __post_init__(self) -> None:
        pairs = {
            "focus.level_unit": (self.focus.level_unit, "dB re 1 um"),
            "friction.level_unit": (self.friction.level_unit, "dB re 1 V"),
            "friction.rate_hz": (self.friction.rate_hz, self.setup.rate_hz),
            "friction.duration_s": (self.friction.duration_s, self.focus.duration_s),
        }
        for name, (value, partner) in pairs.items():
            expect(value == partner, f"Hybrid.{name}", value, f"{partner}, so that both play together")
        finite("Hybrid", electrode_offset_db=self.electrode_offset_db)

    @property
    def setup(self) -> Setup:
        return self.focus.setup

    @property
    def duration_s(self) -> float:
        return self.focus.duration_s

    @property
    def level_unit(self) -> str:
        return self.focus.level_unit

    def at(self, level: float) -> Signal:
        """Return the samples (n_transducers + 1, n_samples) in volt.

        Raises `InvalidParameter` if the level is not finite. Raises `LimitExceeded` if the foci need more than
        `focus.voltage_max_v`.
        """
        return _together(self.focus, self.friction, level, self.electrode_offset_db)


@dataclass(frozen=True)
class MeasuredHybrid:
    """A `Hybrid` whose foci come from responses measured on a bench."""

    focus: TimeReversalStimulus
    friction: AmplitudeModulated
    electrode_offset_db: float

    @property
    def level_unit(self) -> str:
        return self.focus.level_unit

    def at(self, level: float) -> Signal:
        """Return the signal at a level; see `Hybrid.at`."""
        return _together(self.focus, self.friction, level, self.electrode_offset_db)


def measured(hybrid: Hybrid, heard: Responses) -> MeasuredHybrid:
    """Return these foci and this friction, made from measured responses.

    Both have the sampling rate of the responses.

    Raises `InvalidParameter` if the responses do not suit the foci
    (`tactometry.stimuli.time_reversal.stimulus.focus_train.measured`).

    >>> setup = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3)
    >>> both = Hybrid(FocusTrain(setup, f_max_hz=20e3), AmplitudeModulated(120.0, duration_s=0.5, rate_hz=50e3))
    >>> result = measured(both, setup.responses_at(*setup.focus_m))
    >>> bool(np.allclose(result.at(0.0).samples, both.at(0.0).samples))
    True
    """
    friction = replace(hybrid.friction, rate_hz=heard.rate_hz)
    return MeasuredHybrid(focus_train.measured(hybrid.focus, heard), friction, hybrid.electrode_offset_db)


def _together(
    train: FocusTrain | TimeReversalStimulus, waveform: AmplitudeModulated, level: float, offset_db: float
) -> Signal:
    """Stack the channels; a supply voltage also switches the electrode."""
    foci, friction = train.at(level), waveform.at(level + offset_db)
    if train.supply_v is not None:
        friction = pulses(friction, train.supply_v)
    samples = np.zeros((foci.samples.shape[0] + 1, friction.samples.shape[1]))
    samples[:-1, : foci.samples.shape[1]] = foci.samples
    samples[-1] = friction.samples[0]
    return Signal(samples, friction.rate_hz, "V")


@dataclass(frozen=True)
class HybridSensation:
    """Settings of a scene of foci and friction.

    `tactometry.stimuli.scenes.default_scenes.default_scene` builds the scene. Its level is that of the stronger
    stimulus.

    Neither stimulus masks the other (an unverified simplification). The foci are felt as if the finger rested at the
    focus, at any force; the friction is felt only while the finger slides.

    Parameters
    ----------
    setup : Setup
        Screen and focus of the stimulus.
    friction : ElectrovibrationSensation
        Sensation of the friction from the electrode.
    reference_m : float
        Amplitude of a single focus at the detection threshold (the thesis: about 10 um).

    >>> HybridSensation(friction=ElectrovibrationSensation(law="interface")).friction.law
    'interface'
    """

    setup: Setup = field(default_factory=Setup)
    friction: ElectrovibrationSensation = field(default_factory=ElectrovibrationSensation)
    reference_m: float = FOCUS_AT_THRESHOLD_M

    def __post_init__(self) -> None:
        positive("HybridSensation", reference_m=self.reference_m)
