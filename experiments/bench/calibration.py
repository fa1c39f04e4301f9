"""Calibrations of a bench: what was measured, fitted and said in the words of a bench file."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tactometry.devices.outputs.gain import Gain
from tactometry.devices.sensors.reader import Listener, Reader, SampleBlock
from tactometry.errors import DeviceFailed, InvalidParameter, Stopped
from tactometry.rigs.pages.layout import bar_page
from tactometry.rigs.pages.page import Display, Input
from tactometry.rigs.pages.presenter import Presenter, ending
from tactometry.rigs.texts import texts_in

FloatArray = NDArray[np.float64]

STANDARD_GRAVITY_M_PER_S2: Final = 9.80665
FIRST_SAMPLE_WITHIN_S: Final = 5.0
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
    if degree < 1 or mass.ndim != 1 or mass.shape != count.shape or len(mass) < degree + 2:
        raise InvalidParameter(
            f"fit_force: found {mass.size} masses and {count.size} counts, expected as many of both, at least "
            f"{max(degree, 1) + 2} for degree {degree}"
        )
    if not (np.isfinite(mass).all() and np.isfinite(count).all() and np.all(mass >= 0)):
        raise InvalidParameter("fit_force: found a mass or a count that is no finite number, or a mass below 0")
    steps = np.diff(count[np.argsort(mass, kind="stable")])
    if not (np.all(steps > 0) or np.all(steps < 0)):
        raise InvalidParameter(
            "fit_force: found counts that neither rise nor fall with the weights, expected that; measure them again"
        )
    forces_n = mass * gravity_m_per_s2
    fitted = np.polynomial.Polynomial.fit(count, forces_n, degree).convert().coef
    return ForceFit(count, forces_n, tuple(float(c) for c in np.pad(fitted, (0, degree + 1 - len(fitted)))))


@dataclass(frozen=True, eq=False)
class GainFit:
    """Peak volts at the load against what was played, as parts of full scale; the line through zero."""

    units: FloatArray
    volts: FloatArray
    volts_per_unit: float

    @property
    def residuals_v(self) -> FloatArray:
        return np.asarray(self.volts - self.volts_per_unit * self.units)

    @property
    def residual_rms_v(self) -> float:
        return float(np.sqrt(np.mean(np.square(self.residuals_v))))


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
    if unit.ndim != 1 or unit.shape != volt.shape or len(unit) < 2:
        raise InvalidParameter(f"fit_gain: found {unit.size} and {volt.size} values, expected as many, at least two")
    if not (np.all(unit > 0) and np.all(volt > 0) and np.isfinite(unit).all() and np.isfinite(volt).all()):
        raise InvalidParameter("fit_gain: found a value that is not a finite number above 0, expected peak voltages")
    fit = GainFit(unit, volt, float(unit @ volt / (unit @ unit)))
    off = np.abs(fit.residuals_v) / (fit.volts_per_unit * unit)
    if off.max() > RESIDUAL_AT_MOST:
        worst = int(np.argmax(off))
        raise InvalidParameter(
            f"fit_gain: found {volt[worst]:.6g} V at {unit[worst]:g} of full scale, {off[worst]:.0%} off the line "
            f"through zero, expected at most {RESIDUAL_AT_MOST:.0%}; measure again, below what clips"
        )
    return fit


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
    why = ending(events)
    if why is not None:
        raise Stopped(f"{why}; nothing was measured")
    return False


def display_height_m(bar_m: float) -> float:
    """The height of a display on which the bar of `BAR_PART` of it measures `bar_m`.

    >>> display_height_m(0.149)
    0.298
    """
    if not 0 < bar_m < 5:
        raise InvalidParameter(f"display: found a bar of {bar_m} m, expected above 0 and below 5 m")
    return bar_m / BAR_PART


def force_toml(fit: ForceFit, sensor: str, channel: int, on: date, by: str) -> str:
    """The fit as the table ``[force]`` of a bench file; beyond the weights' counts the force counts as unknown."""
    span = float(np.ptp(fit.counts))
    low, high = float(fit.counts.min()) - 0.1 * span, float(fit.counts.max()) + 0.1 * span
    coefficients = ", ".join(repr(c) for c in fit.polynomial)
    return (
        f"[force]\nsensor = {_text(sensor)}\nchannel = {channel}\npolynomial = [{coefficients}]\n"
        f"count_low = {low!r}\ncount_high = {high!r}\nmeasured_on = {on}\nmeasured_by = {_text(by)}\n"
    )


def gain_toml(gain: Gain) -> str:
    """The table ``[output.gain]``, with all that it states."""
    stated = {name: value for name, value in vars(gain).items() if value is not None}
    words = {name: _text(value) if isinstance(value, str) else str(value) for name, value in stated.items()}
    return "[output.gain]\n" + "".join(f"{name} = {value}\n" for name, value in words.items())


def display_toml(height_m: float) -> str:
    return f"[screen]\nheight_m = {height_m!r}\n"


def _text(words: str) -> str:
    return '"' + words.replace("\\", "\\\\").replace('"', '\\"') + '"'


def mean_counts(reader: Reader, channel: int, duration_s: float = 1.0) -> float:
    """The mean of a channel of an open reader over a while, from its first sample on.

    Raises
    ------
    InvalidParameter
        If the sensor has no such channel.
    DeviceFailed
        If it is silent.
    """
    source = reader.source
    if not 0 <= channel < source.n_channels:
        raise InvalidParameter(
            f"channel: found {channel}, expected from 0 to {source.n_channels - 1}, of {source.name}"
        )
    first = _first(reader, listener := reader.listen())
    time.sleep(duration_s)
    return float(np.concatenate([first.values, listener.read(source.n_channels).values])[:, channel].mean())


def _first(reader: Reader, listener: Listener) -> SampleBlock:
    """The first samples; a board may begin a while after its line was opened."""
    end_s = time.perf_counter() + FIRST_SAMPLE_WITHIN_S
    while time.perf_counter() < end_s:
        block = listener.read(reader.source.n_channels)
        if block.times_s.size:
            return block
        time.sleep(0.01)
    raise DeviceFailed(
        f"{reader.source.name}: found no sample in {FIRST_SAMPLE_WITHIN_S:g} s, expected a sensor that sends"
    )
