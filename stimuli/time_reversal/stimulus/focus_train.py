"""Foci and trains of foci, with the unloaded amplitude as the level."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Final, Literal

import numpy as np

from tactometry.arguments.checked import Positive, checked
from tactometry.arguments.require import expect, one_of, positive, whole, within
from tactometry.errors import InvalidParameter, LimitExceeded
from tactometry.signal import Signal

from ...defaults import F_MAX_HZ
from ..filters import Band
from ..focusing.bursts import Bursts, check_supply
from ..focusing.focusing import emitted
from ..focusing.one_bit import OneBit
from ..focusing.pattern import (
    ENVELOPES,
    MODULATIONS,
    PATTERNS,
    EnvelopeName,
    Pattern,
    Table,
    focus_samples,
    focus_starts,
    pattern_drive,
    reversed_waveforms,
)
from ..focusing.quantiser import Analogue, Quantiser
from ..focusing.sigma_delta import SigmaDelta
from ..responses.responses import Responses, band_limited, samples_in
from ..screen.transducer import VOLTAGE_MAX_V
from .setup import Setup

LEVEL_UNITS: Final = ("m", "dB re 1 um")
HIGHEST_LEVEL_DB: Final = 400.0

Drive = Literal["one_bit", "analogue", "sigma_delta_1", "sigma_delta_2"]

DRIVES: Final[dict[str, Quantiser]] = {
    "one_bit": OneBit(),
    "analogue": Analogue(),
    "sigma_delta_1": SigmaDelta(order=1),
    "sigma_delta_2": SigmaDelta(order=2),
}


@checked
@dataclass(frozen=True, eq=False)
class TimeReversalStimulus:
    """A stimulus whose level is the amplitude at the focus without a finger.

    Parameters
    ----------
    focus : Responses
        Filtered displacement responses of the model or from a measurement, at one point or the points of `path`.
    pattern : Pattern
        Pattern of foci; default P0, one focus. The level is its largest focus, including overlaps.
    quantiser : Quantiser, optional
        Quantiser of the reversed responses; default one bit.
    reversal_s : float, optional
        T, above 0; by default the length of the responses.
    voltage_max_v : float
        Largest voltage of the amplifier, above 0.
    level_unit : str
        ``m`` or ``dB re 1 um``.
    heard : Responses, optional
        Unfiltered responses at the foci, whose amplitude is the level; by default `focus`.
    path : sequence of int, optional
        Row of each focus of the pattern for a moving focus, as in `pattern_drive`.
    modulation : str
        ``voltage`` or ``burst``, which needs `tau_s` (above 0).
    supply_v : float, optional
        Voltage of an amplifier that switches between this voltage, its negative and off. The burst lengths set the
        level and the weights of the pattern, each focus to 2 %; `voltage_max_v` and `modulation` are not used.

    >>> h = Responses(1e-9 * np.array([[[3.0, -2.0, 1.0]]]), 1e3)
    >>> stimulus = TimeReversalStimulus(h, level_unit="dB re 1 um")
    >>> stimulus.voltage_v(-20.0)
    16.66666...
    """

    focus: Responses
    pattern: Pattern = PATTERNS["P0"]
    quantiser: Quantiser | None = None
    reversal_s: Positive | None = None
    voltage_max_v: Positive = VOLTAGE_MAX_V
    level_unit: str = "m"
    heard: Responses | None = None
    path: Sequence[int] | None = None
    modulation: str = "voltage"
    tau_s: float | None = None
    supply_v: float | None = None

    def __post_init__(self) -> None:
        one_of("TimeReversalStimulus.level_unit", self.level_unit, LEVEL_UNITS)
        one_of("TimeReversalStimulus.focus.quantity", self.focus.quantity, ("displacement",))
        one_of("TimeReversalStimulus.modulation", self.modulation, MODULATIONS)
        responses, focus = self.heard, self.focus
        if responses is not None:
            found = f"{responses.n_points} points and {responses.n_channels} channels"
            expected = f"{focus.n_points} and {focus.n_channels} as in focus"
            expect(
                responses.samples.shape[:2] == focus.samples.shape[:2], "TimeReversalStimulus.heard", found, expected
            )
        check_supply("TimeReversalStimulus", self.supply_v, self.quantiser)
        if self.reversal_s is not None:
            whole("TimeReversalStimulus", lowest=1, n_reversal=self._n_reversal)

    def at(self, level: float) -> Signal:
        """Return the drive (V) whose largest focus has this amplitude.

        Raises `InvalidParameter` if the amplitude is not above 0, and `LimitExceeded` if it needs more than
        `voltage_max_v` or no burst at `supply_v` makes it.
        """
        if self.supply_v is not None:
            return self._at_supply(level)
        voltage_v = self.voltage_v(level)
        if voltage_v > self.voltage_max_v * (1 + 1e-12):
            raise LimitExceeded(
                f"level: found {level} {self.level_unit}, which needs {voltage_v:.4g} V, above the "
                f"{self.voltage_max_v:.4g} V of the amplifier; the largest level is {self.level_max:.6g}"
            )
        return Signal(voltage_v * self._unit.samples, self._unit.rate_hz, "V")

    def _at_supply(self, level: float) -> Signal:
        try:
            return self._bursts.drive(self._amplitude_m(level) * self.pattern.weights)
        except LimitExceeded as error:
            raise LimitExceeded(
                f"level: found {level} {self.level_unit}, {error}; the largest level is about {self.level_max:.6g}: "
                "lower it, lengthen reversal_s, or raise the supply"
            ) from None

    def voltage_v(self, level: float) -> float:
        """Return the peak voltage of a level without computing the drive."""
        return self.supply_v or self._amplitude_m(level) / self.metres_per_volt

    @cached_property
    def metres_per_volt(self) -> float:
        """Amplitude of the largest focus per peak volt."""
        n = self.focus.n_samples if self.reversal_s is None else self._n_reversal
        instants = focus_samples(self.pattern, self.focus.rate_hz, n)
        return float(np.abs(emitted(self._unit, self.heard or self.focus)[self._rows, instants]).max())

    @property
    def level_max(self) -> float:
        """Largest level within `voltage_max_v`, or of a single focus by bursts."""
        by_voltage = self.supply_v is None
        amplitude_m = self.voltage_max_v * self.metres_per_volt if by_voltage else self._bursts.reach_m
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

    @cached_property
    def _bursts(self) -> Bursts:
        assert self.supply_v is not None
        rate_hz, rule = self.focus.rate_hz, self.quantiser or OneBit()
        waves = reversed_waveforms(self.focus, self._rows, self.reversal_s)
        bits = {row: rule.quantise(wave, rate_hz) for row, wave in waves.items()}
        starts = focus_starts(self.pattern, rate_hz)
        return Bursts([bits[row] for row in self._rows], starts, self.heard or self.focus, self._rows, self.supply_v)

    @property
    def _rows(self) -> list[int]:
        return [0] * self.pattern.n_foci if self.path is None else list(self.path)

    @property
    def _n_reversal(self) -> int:
        return samples_in("reversal_s", self.reversal_s or 0.0, self.focus.rate_hz)

    def _amplitude_m(self, level: float) -> float:
        if self.level_unit == "m":
            positive("TimeReversalStimulus", level=level)
            return level
        within("TimeReversalStimulus", -HIGHEST_LEVEL_DB, HIGHEST_LEVEL_DB, **{"level (dB re 1 um)": level})
        return 1e-6 * 10 ** (level / 20)


@checked
@dataclass(frozen=True)
class FocusTrain:
    """One focus (P0, the default) or a train; the level is the unloaded amplitude of the largest focus.

    Parameters
    ----------
    setup : Setup
        The screen and the place of the focus.
    pattern : str
        P0 (one focus) to P6.
    drive : {"one_bit", "analogue", "sigma_delta_1", "sigma_delta_2"}
        Quantisation of the reversed responses; sigma-delta needs a `setup.rate_hz` of about 1 MHz.
    f_min_hz : float
        Low end of the band of the learnt responses: 20 kHz is filtered, 0.2 kHz unfiltered.
    f_max_hz : float
        High end of the band of the learnt responses: 60 kHz by default.
    reversal_s : float, optional
        T, at most `setup.learnt_s`. Default: the smaller of that and the repetition time, so that drives do not
        overlap.
    voltage_max_v : float
        Largest voltage of the amplifier.
    duration_s : float
        Duration of the interval, at whose start the drive begins.
    level_unit : {"dB re 1 um", "m"}
        Unit of the level: decibel re 1 um, or metre.
    modulation : {"voltage", "burst"}
        Whether a lower voltage or a shorter burst makes a focus weaker.
    supply_v : float, optional
        Voltage of a switching amplifier, above 0 (set by a `packed` output). The burst lengths then set the level.
    repetition_hz : float, optional
        Number of foci per second; overrides the pattern.
    train_s : float, optional
        Duration of a train; overrides the pattern.
    envelope : optional
        Name of the foci's envelope; overrides the pattern.
    envelope_table : optional
        Weights of the foci at equal steps over the train; overrides the pattern.

    >>> stimulus = FocusTrain(Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3), f_max_hz=20e3)
    >>> signal = stimulus.at(0.0)
    >>> signal.samples.shape, round(signal.duration_s * 1e3, 3)
    ((8, 350), 7.0)
    """

    setup: Setup = field(default_factory=Setup)
    pattern: Literal["P0", "P1", "P2", "P3", "P4", "P5", "P6"] = "P0"
    drive: Drive = "one_bit"
    f_min_hz: float = 200.0
    f_max_hz: float = F_MAX_HZ
    reversal_s: Positive | None = None
    voltage_max_v: Positive = VOLTAGE_MAX_V
    duration_s: Positive = 0.5
    level_unit: Literal["dB re 1 um", "m"] = "dB re 1 um"
    repetition_hz: Positive | None = None
    envelope: EnvelopeName | None = None
    train_s: Positive | None = None
    envelope_table: tuple[float, ...] | None = None
    modulation: Literal["voltage", "burst"] = "voltage"
    supply_v: float | None = None

    def __post_init__(self) -> None:
        if self.envelope_table is not None:
            object.__setattr__(self, "envelope_table", tuple(self.envelope_table))
        owner = type(self).__name__
        band = Band(self.f_min_hz, self.f_max_hz)
        if band.f_max_hz > self.setup.modes_to_hz:
            raise InvalidParameter(
                f"{owner}.f_max_hz: found {self.f_max_hz}, above the highest mode at {self.setup.modes_to_hz} Hz; "
                "lower it or raise setup.modes_to_hz"
            )
        _check_times(self)
        check_supply(type(self).__name__, self.supply_v, DRIVES[self.drive])

    @property
    def foci(self) -> Pattern:
        """The pattern with the overridden values."""
        named = PATTERNS[self.pattern]
        envelope = named.envelope if self.envelope is None else ENVELOPES[self.envelope]
        if self.envelope_table is not None:
            envelope = Table(self.envelope_table)
        return Pattern(self.repetition_hz or named.repetition_hz, self.train_s or named.duration_s, envelope)

    def heard(self, learnt: Responses | None = None) -> Responses:
        """Return responses at the focus: the learnt ones, or the model's."""
        return self.setup.responses_at(*self.setup.focus_m) if learnt is None else learnt

    @property
    def emission_s(self) -> float:
        """The reversal time T: `reversal_s` or its default."""
        if self.reversal_s is not None:
            return self.reversal_s
        longest_s = self.setup.learnt_s
        return longest_s if self.foci.n_foci == 1 else min(longest_s, 1 / self.foci.repetition_hz)

    def at(self, level: float) -> Signal:
        """Return the drive (V) whose largest unloaded focus has this amplitude.

        Raises `InvalidParameter` if the level is not finite or not above 0 m, and `LimitExceeded` if it needs more than
        `voltage_max_v` or no burst at `supply_v` makes it.
        """
        return _family(self).at(level)

    def voltage_v(self, level: float) -> float:
        """Return the peak voltage of a level without computing the drive."""
        return _family(self).voltage_v(level)

    @property
    def level_max(self) -> float:
        """The largest level within `voltage_max_v`."""
        return _family(self).level_max


@checked
def measured(train: FocusTrain, heard: Responses) -> TimeReversalStimulus:
    """Return the same foci from responses measured on a bench.

    Raises `InvalidParameter` if the responses have too many points, are not displacements, are too short or have too
    low a rate for the band.

    Parameters
    ----------
    train : FocusTrain
        Foci whose pattern, drive, band, reversal time and voltage apply; the setup does not.
    heard : Responses
        Displacement at the touched point (or at the places of `PlacedFoci`), at least `train.emission_s` long.

    >>> setup = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3)
    >>> train = FocusTrain(setup, f_max_hz=20e3)
    >>> result = measured(train, setup.responses_at(*setup.focus_m))
    >>> result.voltage_v(0.0) == train.voltage_v(0.0)
    True
    """
    at_focus = train.heard(heard)
    n_points, _, n_samples = at_focus.samples.shape
    n_learnt = samples_in("reversal_s", train.emission_s, heard.rate_hz)
    if n_points != 1 or n_samples < n_learnt:
        raise InvalidParameter(
            f"responses: found {n_points} points of {n_samples} samples, expected 1 point of at least {n_learnt} (the "
            f"{train.emission_s:g} s that are reversed); learn longer responses, or shorten reversal_s"
        )
    return _stimulus_of(train, at_focus)


@lru_cache(maxsize=32)
def _family(train: FocusTrain) -> TimeReversalStimulus:
    return _stimulus_of(train, train.heard())


def _stimulus_of(train: FocusTrain, heard: Responses) -> TimeReversalStimulus:
    learnt_s = max(train.setup.learnt_s, train.emission_s)
    learnt = replace(heard, samples=heard.samples[..., : samples_in("learnt_s", learnt_s, heard.rate_hz)])
    return TimeReversalStimulus(
        band_limited(learnt, Band(train.f_min_hz, train.f_max_hz)),
        train.foci,
        DRIVES[train.drive],
        train.emission_s,
        train.voltage_max_v,
        train.level_unit,
        heard,
        modulation=train.modulation,
        tau_s=train.setup.tau_s,
        supply_v=train.supply_v,
    )


def _check_times(train: FocusTrain) -> None:
    owner = type(train).__name__
    n_reversal = samples_in("reversal_s", train.emission_s, train.setup.rate_hz)
    whole(f"{owner}.reversal_s", lowest=1, n_samples=n_reversal)
    if train.emission_s > train.setup.learnt_s:
        raise InvalidParameter(
            f"{owner}.reversal_s: found {train.reversal_s}, longer than the responses of {train.setup.learnt_s} s; "
            "shorten it or raise setup.learnt_s"
        )
    needed_s = float(train.foci.times_s[-1]) + train.emission_s
    if needed_s > train.duration_s:
        raise InvalidParameter(
            f"{owner}.duration_s: found {train.duration_s}, shorter than the {needed_s:.6g} s of the drive; raise it"
        )
