"""Calibrations of a bench, returned as keys of the bench file."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import Final, NamedTuple

import numpy as np

from tactometry.arguments.require import expect
from tactometry.devices.sensors.reader import Reader
from tactometry.errors import DeviceFailed, InvalidParameter, Stopped
from tactometry.rigs.pages.layout import bar_page
from tactometry.rigs.pages.page import Display, Input
from tactometry.rigs.pages.presenter import Presenter, reason_to_end
from tactometry.rigs.texts import texts_in
from tactometry.signal import FloatArray, Signal

STANDARD_GRAVITY_M_PER_S2: Final = 9.80665
FIRST_SAMPLE_WITHIN_S: Final = 5.0
TONE_HZ: Final = 100.0
RESIDUAL_AT_MOST: Final = 0.05
"""Largest residual of a fit, relative to the gain or to the largest force. Limits and gates are only as accurate as
these fits (unverified default)."""
BAR_PART: Final = 0.5
"""Length of the bar that is measured on a display, as a fraction of the display's height."""
BAR_WORDS: Final = """Measure the white bar

Hold a ruler against the screen and read
the length of the bar, from end to end.

Remember it: you type it into the terminal,
in metres, once this page is closed."""


@dataclass(frozen=True, eq=False)
class ForceFit:
    """Fitted force polynomial (N, N per count, ...) and the fitted points."""

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
    residual_at_most: float = RESIDUAL_AT_MOST,
) -> ForceFit:
    """Fit the force of weights over a sensor's counts by least squares.

    Raises `InvalidParameter` if there are fewer than `degree` + 2 weights, a number is not finite, or a mass is below
    0. Also if the counts neither rise nor fall with the weights, or a residual exceeds `residual_at_most` of the
    largest force.

    Examples
    --------
    >>> fit = fit_force([0.0, 0.1, 0.2, 0.5], [10.0, 110.0, 210.0, 510.0], gravity_m_per_s2=10.0)
    >>> [round(c, 9) for c in fit.polynomial], bool(fit.residual_rms_n < 1e-12)
    ([-0.1, 0.01], True)
    """
    mass, count = np.asarray(masses_kg, float), np.asarray(counts, float)
    enough = degree >= 1 and mass.ndim == 1 and mass.shape == count.shape and len(mass) >= degree + 2
    expected = f"equally many of both, at least {max(degree, 1) + 2} for degree {degree}"
    expect(enough, "fit_force", f"{mass.size} masses and {count.size} counts", expected)
    if not (np.isfinite(mass).all() and np.isfinite(count).all() and np.all(mass >= 0)):
        raise InvalidParameter("fit_force: found a mass or a count that is not finite, or a mass below 0")
    steps = np.diff(count[np.argsort(mass, kind="stable")])
    follows = np.all(steps > 0) or np.all(steps < 0)
    expect(
        follows,
        "fit_force",
        "counts that neither rise nor fall with the weights",
        "a steady rise or fall; measure them again",
    )
    forces_n = mass * gravity_m_per_s2
    fitted = np.polynomial.Polynomial.fit(count, forces_n, degree).convert().coef
    fit = ForceFit(count, forces_n, tuple(float(c) for c in np.pad(fitted, (0, degree + 1 - len(fitted)))))
    off = np.abs(fit.residuals_n) / fit.forces_n.max()
    worst = int(np.argmax(off))
    place = f"{count[worst]:.6g} counts at {mass[worst]:g} kg, off the fit by {off[worst]:.1%} of the largest force"
    most = f"at most {100 * residual_at_most:g}%; weigh again, or fit a higher degree"
    expect(off[worst] <= residual_at_most, "fit_force", place, most)
    return fit


class GainFit(NamedTuple):
    """Fitted peak voltage at the load for full scale, and its residual."""

    volts_per_unit: float
    residual_rms_v: float


def fit_gain(units: Sequence[float], volts: Sequence[float], *, residual_at_most: float = RESIDUAL_AT_MOST) -> GainFit:
    """Fit a line through zero by least squares.

    Raises `InvalidParameter` if there are fewer than two points, a value is not above 0, or a point is off the line by
    more than the share `residual_at_most`.

    Examples
    --------
    >>> round(fit_gain([0.1, 0.2], [5.0, 10.0]).volts_per_unit, 9)
    50.0
    """
    unit, volt = np.asarray(units, float), np.asarray(volts, float)
    paired = unit.ndim == 1 and unit.shape == volt.shape and len(unit) >= 2
    expect(paired, "fit_gain", f"{unit.size} and {volt.size} values", "equally many of both, at least two")
    above_0 = all(np.all((values > 0) & np.isfinite(values)) for values in (unit, volt))
    expect(above_0, "fit_gain", "a value that is not a finite number above 0", "peak voltages")
    volts_per_unit = float(unit @ volt / (unit @ unit))
    line_v = volts_per_unit * unit
    off = np.abs(volt - line_v) / line_v
    worst = int(np.argmax(off))
    place = f"{volt[worst]:.6g} V at {unit[worst]:g} of full scale, {off[worst]:.1%} off the line through zero"
    most = f"at most {100 * residual_at_most:g}%; measure again without clipping"
    expect(off[worst] <= residual_at_most, "fit_gain", place, most)
    return GainFit(volts_per_unit, float(np.sqrt(np.mean(np.square(volt - line_v)))))


def show_bar(screen: Display) -> None:
    """Show a bar to measure, until a key is pressed or the screen touched.

    Raises `Stopped` if Escape was pressed or the window was closed.
    """
    page = bar_page(BAR_WORDS, texts_in("en", {}).message("hint_continue"), screen.aspect, BAR_PART)
    Presenter(screen, _give_up).converse(None, lambda state: page, lambda state, answer: (state, True))


def _give_up(events: tuple[Input, ...]) -> bool:
    why = reason_to_end(events)
    if why is not None:
        raise Stopped(f"{why}; nothing was measured")
    return False


def display_height_m(bar_m: float) -> float:
    """Compute the display height from the measured length of the bar.

    >>> display_height_m(0.149)
    0.298
    """
    expect(0 < bar_m < 5, "display", f"a bar of {bar_m} m", "above 0 and below 5 m")
    return bar_m / BAR_PART


def force_values(fit: ForceFit, sensor: str, channel: int, on: date, by: str) -> dict[str, object]:
    """Return the fit as keys of the bench file's ``[force]`` table.

    The force is unknown outside the counts of the weights. Keys of other kinds of calibration are None.
    """
    span = float(np.ptp(fit.counts))
    low, high = float(fit.counts.min()) - 0.1 * span, float(fit.counts.max()) + 0.1 * span
    fitted = {"sensor": sensor, "channel": channel, "polynomial": fit.polynomial, "count_low": low, "count_high": high}
    others = dict.fromkeys(("newtons_per_count", "zero_count", "table_counts", "table_forces_n"))
    return {**fitted, **others, "measured_on": on, "measured_by": by}


def mean_counts(reader: Reader, channel: int, duration_s: float = 1.0) -> float:
    """Average a channel of an open reader, starting at its first sample.

    Raises `InvalidParameter` if the sensor has no such channel. Raises `DeviceFailed` if the sensor sends nothing.
    """
    reader.check_channels("channel", channel)
    listener = reader.listen()
    # A board may start sending only some time after its port is opened.
    first = next(listener.blocks(time.perf_counter() + FIRST_SAMPLE_WITHIN_S), None)
    if first is None:
        silent = f"found no sample in {FIRST_SAMPLE_WITHIN_S:g} s, expected a sensor that sends"
        raise DeviceFailed(f"{reader.source.name}: {silent}")
    time.sleep(duration_s)
    return float(np.concatenate([first.values, listener.read().values])[:, channel].mean())


def tone(voltage_v: float, n_channels: int, rate_hz: float, duration_s: float, ramp_s: float) -> Signal:
    """Return a 100 Hz test sine with ramps, (n_channels, n_samples)."""
    times_s = np.arange(round(duration_s * rate_hz)) / rate_hz
    to_an_end_s = np.minimum(times_s, duration_s - times_s)
    ramp = np.sin(np.pi / 2 * np.clip(to_an_end_s / ramp_s, 0, 1)) ** 2
    samples = voltage_v * ramp * np.sin(2 * np.pi * TONE_HZ * times_s)
    return Signal(np.tile(samples, (n_channels, 1)), rate_hz, "V")
