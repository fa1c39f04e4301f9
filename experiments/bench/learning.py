"""Measurement of a bench's impulse responses, one channel at a time."""

import math
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Annotated, Final, NamedTuple

import numpy as np
from annotated_types import Ge

from tactometry.arguments.constraints import constrained
from tactometry.arguments.require import expect
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.sensors.reader import Listener, Reader
from tactometry.errors import DeviceFailed, count_of
from tactometry.signal import FloatArray, Signal
from tactometry.stimuli.time_reversal.responses.learning import Excitation, as_displacement, deconvolve
from tactometry.stimuli.time_reversal.responses.responses import Responses

LEAD_S: Final = 0.1
REPEATABILITY: Final = 0.9
"""Smallest share of a focus that must remain between repeated responses (unverified default)."""
CLIPPED: Final = 0.999


@dataclass(frozen=True)
class Microphone:
    """Sensor channels of a point (`channel`) and of the drive (`reference`).

    One count equals `units_per_count` (m, m/s or m/s^2) at the point, and `volts_per_count` (V) at the load.
    """

    reader: Reader
    channel: int
    reference: int
    units_per_count: float
    volts_per_count: float

    def __post_init__(self) -> None:
        n = self.reader.source.n_channels
        two = len({self.channel, self.reference} & set(range(n))) == 2
        expected = f"two different channels from 0 to {n - 1} of {self.reader.source.name}"
        expect(two, "channel, reference", f"{self.channel} and {self.reference}", expected)


@dataclass(frozen=True)
@constrained
class Learning:
    """Settings for learning impulse responses.

    Each of the `channels` plays the excitation `n_repeats` times at `voltage_v`. The first `duration_s` of the response
    are kept.
    `reference_output` is an output channel that also plays the drive and is wired to the reference input. Without it,
    the reference input must record whichever channel plays.
    """

    excitation: Excitation
    voltage_v: float
    channels: tuple[int, ...]
    duration_s: float
    quantity: str = "displacement"
    reference_output: int | None = None
    regularisation: float = 1e-6
    n_repeats: Annotated[int, Ge(1)] = 2

    @property
    def recorded_s(self) -> float:
        """Duration of a recording: excitation, response, and pauses around them."""
        return len(self.excitation.samples) / self.excitation.rate_hz + self.duration_s + 2 * LEAD_S


class Heard(NamedTuple):
    """Responses (1, 1, n_samples) of the repetitions and of silence."""

    repeats: tuple[Responses, ...]
    quiet: Responses

    @property
    def mean(self) -> Responses:
        first = self.repeats[0]
        return Responses(np.mean([each.samples for each in self.repeats], axis=0), first.rate_hz, first.quantity)


class Quality(NamedTuple):
    """Quality of the measured responses of a channel.

    `snr_db` is the energy of the response over that of the response computed from silence. It is infinite without
    noise. `repeatability` is the smallest normalised correlation between two responses of the channel. It equals the
    share of a focus that remains if one response drives it and the other one is true.
    """

    snr_db: float
    repeatability: float


def quality(heard: Heard, band_hz: tuple[float, float]) -> Quality:
    """Compute the quality of at least two responses in a frequency band.

    Examples
    --------
    >>> early, none = (Responses(shape[None, None], 1e3) for shape in (np.eye(64)[9], np.zeros(64)))
    >>> quality(Heard((early, early), quiet=none), (100.0, 400.0)).snr_db
    inf
    >>> quality(Heard((early, early), quiet=early), (100.0, 400.0)).snr_db
    0.0
    """
    *repeats, quiet = (as_displacement(each, *band_hz).samples.ravel() for each in (*heard.repeats, heard.quiet))
    energies, noise = [float(each @ each) for each in repeats], float(quiet @ quiet)
    with np.errstate(divide="ignore", invalid="ignore"):
        snr_db = 10 * np.log10(np.mean(energies) / noise) if noise else math.inf
    pairs = combinations(zip(repeats, energies, strict=True), 2)
    alike = [float(a @ b) / math.sqrt(e * f) for (a, e), (b, f) in pairs] if all(energies) else [0.0]
    return Quality(float(snr_db), min(alike))


def repeatable(
    heard: Iterable[tuple[int, Heard]], band_hz: tuple[float, float], at_least: float
) -> Iterator[tuple[Heard, Quality]]:
    """Yield each channel's responses and quality. Reject a low repeatability.

    Raises `DeviceFailed` if the repeatability of a channel is below `at_least`.
    """
    for channel, each in heard:
        result = quality(each, band_hz)
        words = f"repeatability {result.repeatability:.3f} at a signal-to-noise ratio of {result.snr_db:.1f} dB"
        cure = f"at least {at_least:g}; repeat louder or longer, without movement. Nothing was written"
        expect(result.repeatability >= at_least, f"channel {channel}", words, cure, DeviceFailed)
        yield each, result


def learn(learning: Learning, output: Guarded, microphone: Microphone) -> Iterator[Heard]:
    """Yield the measured responses to each channel in turn. Opens no device.

    The silence is recorded first. The devices must be open.

    Raises `DeviceFailed` if samples were lost or clipped, playback had gaps, nothing was recorded, or the sampling
    rates differ. Raises `LimitExceeded` if the excitation exceeds a limit.
    """
    rate_hz = microphone.reader.source.rate_hz
    excitation_hz, output_hz = learning.excitation.rate_hz, output.driver.rate_hz
    rates = f"an excitation at {excitation_hz:g} Hz, an output at {output_hz} Hz and a sensor at {rate_hz:g} Hz"
    is_one = excitation_hz == rate_hz and output_hz in (None, rate_hz)
    expect(is_one, "calibrate", rates, "the same sampling rate; nothing was played", DeviceFailed)
    listener = microphone.reader.listen()
    quiet = _record(listener, microphone, time.perf_counter() + learning.recorded_s)
    for channel in learning.channels:
        signal = _signal(learning, channel, output.driver.n_channels or max(learning.channels) + 1)
        recorded = [_played(learning, signal, output, listener, microphone) for _ in range(learning.n_repeats)]
        repeats = tuple(_response(learning, microphone, each) for each in recorded)
        yield Heard(repeats, _response(learning, microphone, recorded[0], quiet))


def _played(
    learning: Learning, signal: Signal, output: Guarded, listener: Listener, microphone: Microphone
) -> FloatArray:
    """Play a signal and return its recording, (n_channels, n_samples)."""
    listener.read()  # discard samples that arrived before this recording
    time.sleep(LEAD_S)
    onset_s = output.play(signal)
    recorded = _record(listener, microphone, onset_s + learning.recorded_s - LEAD_S)
    expect_whole(output)
    return recorded


def expect_whole(output: Guarded) -> None:
    """Raise `DeviceFailed` if an output played with gaps."""
    if n_gaps := output.n_gaps():
        result = f"found {count_of(n_gaps, 'gap')} in playback, expected none"
        raise DeviceFailed(f"output {output.name!r}: {result}; close other programs and repeat the measurement")


def join(responses: Sequence[Responses]) -> Responses:
    """Join the responses of one point to several channels."""
    samples = np.concatenate([response.samples for response in responses], axis=1)
    return Responses(samples, responses[0].rate_hz, responses[0].quantity)


def _signal(learning: Learning, channel: int, n_channels: int) -> Signal:
    samples = np.zeros((n_channels, len(learning.excitation.samples)))
    reference = channel if learning.reference_output is None else learning.reference_output
    for played in {channel, reference}:
        expect(0 <= played < n_channels, "channel", played, f"an output channel from 0 to {n_channels - 1}")
        samples[played] = learning.voltage_v * learning.excitation.samples
    return Signal(samples, learning.excitation.rate_hz, "V")


def _record(listener: Listener, microphone: Microphone, end_s: float) -> FloatArray:
    """Record (n_channels, n_samples) up to `end_s` without gaps."""
    source = microphone.reader.source
    values: list[FloatArray] = []
    for block in listener.blocks(end_s + 2.0):
        values.append(block.values)
        if block.times_s[-1] >= end_s:
            break
    else:
        raise DeviceFailed(f"{source.name}: the sensor stopped sending during a recording; repeat it")
    recorded = np.concatenate(values).T
    chosen = recorded[[microphone.channel, microphone.reference]]
    if microphone.reader.facts().get("n_overruns"):
        raise DeviceFailed(f"{source.name}: samples were lost in the recording; close other programs and repeat it")
    if np.abs(chosen).max() >= CLIPPED:
        raise DeviceFailed(f"{source.name}: the recording is clipped; lower the voltage or the sensor's range")
    return recorded


def _response(
    learning: Learning, microphone: Microphone, recorded: FloatArray, heard: FloatArray | None = None
) -> Responses:
    """Compute the response from a recording's drive.

    The point's signal is taken from the same recording, or from `heard`.
    """
    heard = recorded if heard is None else heard
    drive = recorded[microphone.reference] * microphone.volts_per_count
    point = heard[microphone.channel] * microphone.units_per_count
    if not (recorded[microphone.channel].any() and drive.any()):
        name = microphone.reader.source.name
        raise DeviceFailed(
            f"{name}: found no signal on the channel or its reference, expected one on both; check the cables"
        )
    n = math.ceil(learning.duration_s * learning.excitation.rate_hz)
    response = deconvolve(drive, point, n, regularisation=learning.regularisation)
    return Responses(response[None, None], learning.excitation.rate_hz, learning.quantity)
