"""Calibrations of a bench: what was measured, fitted and said in the words of a bench file.

Impulse responses are learnt as one channel plays after the other, while a sensor and a reference record.
"""

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.require import expect
from tactometry.devices.outputs.gain import Gain
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.sensors.reader import Listener, Reader
from tactometry.errors import DeviceFailed, InvalidParameter, Stopped
from tactometry.rigs.pages.layout import bar_page
from tactometry.rigs.pages.page import Display, Input
from tactometry.rigs.pages.presenter import Presenter, reason_to_end
from tactometry.rigs.texts import texts_in
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.responses.learning import Excitation, deconvolve
from tactometry.stimuli.time_reversal.responses.responses import Responses

FloatArray = NDArray[np.float64]

STANDARD_GRAVITY_M_PER_S2: Final = 9.80665
FIRST_SAMPLE_WITHIN_S: Final = 5.0
TONE_HZ: Final = 100.0
LEAD_S: Final = 0.1
CLIPPED: Final = 0.999
RESIDUAL_AT_MOST: Final = 0.05
"""Largest part by which a measured voltage may be off the line of a gain: the limits are as exact as it is (unverified
default)."""
BAR_PART: Final = 0.5
"""The bar that is measured on a display, as a part of its height."""
BAR_WORDS: Final = """Measure the white bar

Hold a ruler against the screen and read
the length of the bar, from end to end.

Remember it: you type it into the terminal,
in metres, once this page is closed."""


@dataclass(frozen=True, eq=False)
class ForceFit:
    """Forces of weights against counts: the polynomial (N, N per count, ...) and what it leaves, N."""

    counts: FloatArray
    forces_n: FloatArray
    polynomial: tuple[float, ...]

    @property
    def residuals_n(self) -> FloatArray:
        return np.asarray(self.forces_n - np.polynomial.polynomial.polyval(self.counts, self.polynomial))

    @property
    def residual_rms_n(self) -> float:
        return float(np.sqrt(np.mean(np.square(self.residuals_n))))


def fit_force(
    masses_kg: Sequence[float],
    counts: Sequence[float],
    *,
    degree: int = 1,
    gravity_m_per_s2: float = STANDARD_GRAVITY_M_PER_S2,
) -> ForceFit:
    """Least squares of the weights' force on the sensor's counts.

    Raises
    ------
    InvalidParameter
        If there are fewer than `degree` + 2 weights, a number is not finite, a mass is below 0, or counts neither rise
        nor fall with the weights.

    Examples
    --------
    >>> fit = fit_force([0.0, 0.1, 0.2, 0.5], [10.0, 110.0, 210.0, 510.0], gravity_m_per_s2=10.0)
    >>> [round(c, 9) for c in fit.polynomial], bool(fit.residual_rms_n < 1e-12)
    ([-0.1, 0.01], True)
    """
    mass, count = np.asarray(masses_kg, float), np.asarray(counts, float)
    enough = degree >= 1 and mass.ndim == 1 and mass.shape == count.shape and len(mass) >= degree + 2
    expected = f"as many of both, at least {max(degree, 1) + 2} for degree {degree}"
    expect(enough, "fit_force", f"{mass.size} masses and {count.size} counts", expected)
    if not (np.isfinite(mass).all() and np.isfinite(count).all() and np.all(mass >= 0)):
        raise InvalidParameter("fit_force: found a mass or a count that is no finite number, or a mass below 0")
    steps = np.diff(count[np.argsort(mass, kind="stable")])
    follows = np.all(steps > 0) or np.all(steps < 0)
    expect(follows, "fit_force", "counts that neither rise nor fall with the weights", "that; measure them again")
    forces_n = mass * gravity_m_per_s2
    fitted = np.polynomial.Polynomial.fit(count, forces_n, degree).convert().coef
    return ForceFit(count, forces_n, tuple(float(c) for c in np.pad(fitted, (0, degree + 1 - len(fitted)))))


class GainFit(NamedTuple):
    """Peak volts at the load for each part of full scale, and what is left of the line through zero."""

    volts_per_unit: float
    residual_rms_v: float


def fit_gain(units: Sequence[float], volts: Sequence[float]) -> GainFit:
    """Least squares through zero.

    Raises
    ------
    InvalidParameter
        If there are fewer than two points, one is not above 0, or one is off the line by more than
        `RESIDUAL_AT_MOST` of it.

    Examples
    --------
    >>> round(fit_gain([0.1, 0.2], [5.0, 10.0]).volts_per_unit, 9)
    50.0
    """
    unit, volt = np.asarray(units, float), np.asarray(volts, float)
    paired = unit.ndim == 1 and unit.shape == volt.shape and len(unit) >= 2
    expect(paired, "fit_gain", f"{unit.size} and {volt.size} values", "as many, at least two")
    above_0 = all(np.all((values > 0) & np.isfinite(values)) for values in (unit, volt))
    expect(above_0, "fit_gain", "a value that is not a finite number above 0", "peak voltages")
    volts_per_unit = float(unit @ volt / (unit @ unit))
    line_v = volts_per_unit * unit
    off = np.abs(volt - line_v) / line_v
    worst = int(np.argmax(off))
    place = f"{volt[worst]:.6g} V at {unit[worst]:g} of full scale, {off[worst]:.0%} off the line through zero"
    most = f"at most {RESIDUAL_AT_MOST:.0%}; measure again, below what clips"
    expect(off[worst] <= RESIDUAL_AT_MOST, "fit_gain", place, most)
    return GainFit(volts_per_unit, float(np.sqrt(np.mean(np.square(volt - line_v)))))


def show_bar(screen: Display) -> None:
    """Show the bar that is to be measured until a key is pressed or the screen is touched.

    Raises
    ------
    Stopped
        If Escape was pressed, or the window closed.
    """
    page = bar_page(BAR_WORDS, texts_in("en", {}).message("hint_continue"), screen.aspect, BAR_PART)
    Presenter(screen, _give_up).converse(None, lambda state: page, lambda state, answer: (state, True))


def _give_up(events: tuple[Input, ...]) -> bool:
    why = reason_to_end(events)
    if why is not None:
        raise Stopped(f"{why}; nothing was measured")
    return False


def display_height_m(bar_m: float) -> float:
    """The height of a display on which the bar of `BAR_PART` of it measures `bar_m`.

    >>> display_height_m(0.149)
    0.298
    """
    expect(0 < bar_m < 5, "display", f"a bar of {bar_m} m", "above 0 and below 5 m")
    return bar_m / BAR_PART


def force_toml(fit: ForceFit, sensor: str, channel: int, on: date, by: str) -> str:
    """The fit as the table ``[force]`` of a bench file; beyond the weights' counts the force counts as unknown."""
    span = float(np.ptp(fit.counts))
    low, high = float(fit.counts.min()) - 0.1 * span, float(fit.counts.max()) + 0.1 * span
    fitted = {"sensor": sensor, "channel": channel, "polynomial": fit.polynomial, "count_low": low, "count_high": high}
    return _toml("force", {**fitted, "measured_on": on, "measured_by": by})


def gain_toml(gain: Gain) -> str:
    """The table ``[output.gain]``, with all that it states."""
    return _toml("output.gain", vars(gain))


def display_toml(height_m: float) -> str:
    return _toml("screen", {"height_m": height_m})


def _toml(name: str, values: Mapping[str, object]) -> str:
    """A table of a bench file, without what is None."""
    return f"[{name}]\n" + "".join(f"{key} = {_word(value)}\n" for key, value in values.items() if value is not None)


def _word(value: object) -> str:
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return f"[{', '.join(map(str, value))}]" if isinstance(value, tuple) else str(value)


def mean_counts(reader: Reader, channel: int, duration_s: float = 1.0) -> float:
    """The mean of a channel of an open reader over a while, from its first sample on.

    Raises
    ------
    InvalidParameter
        If the sensor has no such channel.
    DeviceFailed
        If it is silent.
    """
    reader.check_channels("channel", channel)
    listener = reader.listen()
    # a board may begin a while after its line was opened
    first = next(listener.blocks(time.perf_counter() + FIRST_SAMPLE_WITHIN_S), None)
    if first is None:
        raise DeviceFailed(
            f"{reader.source.name}: found no sample in {FIRST_SAMPLE_WITHIN_S:g} s, expected a sensor that sends"
        )
    time.sleep(duration_s)
    return float(np.concatenate([first.values, listener.read().values])[:, channel].mean())


def tone(voltage_v: float, n_channels: int, rate_hz: float, duration_s: float, ramp_s: float) -> Signal:
    """A sine of 100 Hz that tries or measures an output, with a ramp at each end, (n_channels, n_samples)."""
    times_s = np.arange(round(duration_s * rate_hz)) / rate_hz
    to_an_end_s = np.minimum(times_s, duration_s - times_s)
    ramp = np.sin(np.pi / 2 * np.clip(to_an_end_s / ramp_s, 0, 1)) ** 2
    samples = voltage_v * ramp * np.sin(2 * np.pi * TONE_HZ * times_s)
    return Signal(np.tile(samples, (n_channels, 1)), rate_hz, "V")


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
    response = deconvolve(drive, heard, n, regularisation=learning.regularisation)
    return Responses(response[None, None], learning.excitation.rate_hz, learning.quantity)
