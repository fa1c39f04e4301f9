"""Learning a bench's impulse responses: one channel plays after the other, a sensor and a reference record."""

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.require import expect
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.sensors.reader import Listener, Reader
from tactometry.errors import DeviceFailed
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.responses.learning import Excitation, deconvolved
from tactometry.stimuli.time_reversal.responses.responses import Responses

FloatArray = NDArray[np.float64]

LEAD_S: Final = 0.1
CLIPPED: Final = 0.999


@dataclass(frozen=True)
class Microphone:
    """What records a calibration: a channel that measures the point, and one that records the drive itself.

    Parameters
    ----------
    reader : Reader
    channel, reference : int
        Of the sensor, from 0.
    units_per_count : float
        m, m/s or m/s^2 for a count of 1 on `channel`.
    volts_per_count : float
        V at the load for a count of 1 on `reference`.
    """

    reader: Reader
    channel: int
    reference: int
    units_per_count: float
    volts_per_count: float

    def __post_init__(self) -> None:
        n = self.reader.source.n_channels
        two = len({self.channel, self.reference} & set(range(n))) == 2
        expected = f"two of 0 to {n - 1}, those of {self.reader.source.name}"
        expect(two, "channel, reference", f"{self.channel} and {self.reference}", expected)


@dataclass(frozen=True)
class Learning:
    """How responses are learnt: the excitation at `voltage_v` on each of `channels` in turn, `duration_s` of response.

    `reference_output` is an output channel that carries the drive too, for a cable back to the reference; without it,
    the reference must record whichever channel plays.
    """

    excitation: Excitation
    voltage_v: float
    channels: tuple[int, ...]
    duration_s: float
    quantity: str = "displacement"
    reference_output: int | None = None
    regularisation: float = 1e-6


def learn(learning: Learning, output: Guarded, microphone: Microphone) -> Iterator[Responses]:
    """The responses to one channel after the other, each of shape (1, 1, n_samples); both devices are open.

    Raises
    ------
    DeviceFailed
        If samples were lost or clipped, nothing was heard, or the rates differ.
    LimitExceeded
        If the excitation passes a limit.
    """
    rate_hz = microphone.reader.source.rate_hz
    excitation_hz, output_hz = learning.excitation.rate_hz, output.driver.rate_hz
    if excitation_hz != rate_hz or output_hz not in (None, rate_hz):
        raise DeviceFailed(
            f"calibrate: found an excitation at {excitation_hz:g} Hz, an output at {output_hz} Hz and a sensor at "
            f"{rate_hz:g} Hz, expected one rate; nothing was played"
        )
    listener = microphone.reader.listen()
    for channel in learning.channels:
        signal = _signal(learning, channel, output.driver.n_channels or max(learning.channels) + 1)
        listener.read()  # what came before is not of this recording
        time.sleep(LEAD_S)
        onset_s = output.play(signal)
        end_s = onset_s + signal.duration_s + learning.duration_s + LEAD_S
        yield _response(learning, microphone, _record(listener, microphone, end_s))


def join(responses: Sequence[Responses]) -> Responses:
    """One point's responses to several channels."""
    samples = np.concatenate([response.samples for response in responses], axis=1)
    return Responses(samples, responses[0].rate_hz, responses[0].quantity)


def _signal(learning: Learning, channel: int, n_channels: int) -> Signal:
    samples = np.zeros((n_channels, len(learning.excitation.samples)))
    reference = channel if learning.reference_output is None else learning.reference_output
    for played in {channel, reference}:
        expect(0 <= played < n_channels, "channel", played, f"from 0 to {n_channels - 1}, those of the output")
        samples[played] = learning.voltage_v * learning.excitation.samples
    return Signal(samples, learning.excitation.rate_hz, "V")


def _record(listener: Listener, microphone: Microphone, end_s: float) -> FloatArray:
    """(n_channels, n_samples) from the last reading of the listener to `end_s`, without a break."""
    source = microphone.reader.source
    values: list[FloatArray] = []
    for block in listener.blocks(end_s + 2.0):
        values.append(block.values)
        if block.times_s[-1] >= end_s:
            break
    else:
        raise DeviceFailed(f"{source.name}: the sensor fell silent in the middle of a recording; begin again")
    recorded = np.concatenate(values).T
    chosen = recorded[[microphone.channel, microphone.reference]]
    if microphone.reader.facts().get("n_overruns"):
        raise DeviceFailed(f"{source.name}: samples were lost in the recording; close other programs and begin again")
    if np.abs(chosen).max() >= CLIPPED:
        raise DeviceFailed(f"{source.name}: the recording is clipped; lower the voltage or the sensor's range")
    return recorded


def _response(learning: Learning, microphone: Microphone, recorded: FloatArray) -> Responses:
    heard = recorded[microphone.channel] * microphone.units_per_count
    drive = recorded[microphone.reference] * microphone.volts_per_count
    if not (heard.any() and drive.any()):
        raise DeviceFailed(
            f"{microphone.reader.source.name}: the channel or its reference heard nothing, expected both to; check the "
            "cables"
        )
    n = math.ceil(learning.duration_s * learning.excitation.rate_hz)
    response = deconvolved(drive, heard, n, regularisation=learning.regularisation)
    return Responses(response[None, None], learning.excitation.rate_hz, learning.quantity)
