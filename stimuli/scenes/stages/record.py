"""Voltage of a played signal at the electrode, and its effects.

A signal is linear between its samples, as it is played, so that any waveform is processed alike.
"""

from math import exp, log, pi, sin
from typing import TYPE_CHECKING

import numpy as np

from tactometry.arguments.require import expect
from tactometry.signal import Signal

from ...arrays import FloatArray
from ...composition.effect import Demand, Size
from ...composition.sampling import content_of, samples
from ...electrovibration.waveforms.pieces import VoltageRecord
from ...perception.channels import heard
from ...perception.detection import WINDOW, Components, components

if TYPE_CHECKING:
    from ...electrovibration.attraction.force import ForceForm
    from ...electrovibration.skin.skin import Skin
    from ...electrovibration.waveforms.pieces import Pieces

FINER = 2
Tissue = tuple[float, ...]


def recorded(signal: Signal, share: float) -> VoltageRecord:
    """Return the voltage of a signal, resampled if its square would alias.

    It has `FINER` times as many samples (band-limited) if more than a share of its power lies above a quarter of the
    rate. The force is quadratic and has twice the bandwidth. Without resampling, the force of a carrier of 9.9 kHz at
    20 kHz would appear at 200 Hz.

    Raises `InvalidParameter` if the signal is not one channel in volt.
    """
    found = f"{len(signal.samples)} channels in {signal.unit!r}"
    expect(signal.unit == "V" and len(signal.samples) == 1, "signal", found, "one channel in volt ('V')")
    (voltage_v,) = signal.samples
    lines, n = np.fft.rfft(voltage_v), voltage_v.size
    power = lines.real**2 + lines.imag**2
    if n < 4 or power[lines.size // 2 :].sum() <= share * power.sum():
        return VoltageRecord(voltage_v, signal.rate_hz)
    lines[n // 2 :] *= 1.0 if n % 2 else 0.5
    return VoltageRecord(FINER * np.fft.irfft(lines, n=FINER * n), FINER * signal.rate_hz)


def skin(tissue: Tissue, **layers: float) -> "Skin":
    """Return the skin of a surface, with its deeper tissue if any."""
    from ...electrovibration.skin.skin import Skin
    from ...electrovibration.skin.stack import Layer

    return Skin(**layers, tissue=Layer(*tissue) if tissue else None)


def layer_voltage(record: VoltageRecord, form: "ForceForm") -> FloatArray:
    """Return the exact voltage across the layer of a force law."""
    return form.relaxations.sampled(record.voltage_v, record.rate_hz)


def pieces(record: VoltageRecord) -> "Pieces":
    from ...electrovibration.waveforms.pieces import straight

    return straight(record.t_s, record.voltage_v)


def times(record: VoltageRecord) -> FloatArray:
    """Return the times of the samples."""
    return record.t_s


def components_of_record(record: VoltageRecord, course: FloatArray, padding: int) -> Components:
    """Return the components of a course to which any channel responds."""
    return heard(components(course, record.rate_hz, padding))


def grown(parts: Components, area_m2: float, form_area_m2: float) -> Components:
    """Scale the force proportionally from one area to another."""
    return parts.times(area_m2 / form_area_m2)


PADDINGS = (1, 2, 4, 8, 16, 32, 64)
MOST_LINES = 3e7
N_OFFSETS = 21


def peak_error(padding: int, duration_s: float, steepest_db_per_hz: float) -> float:
    """Return the largest reading error of a component for a padding.

    >>> peak_error(1, 1.0, steepest_db_per_hz=0.69) < 0.03, peak_error(8, 1.0, 0.69) < 1e-4
    (True, True)
    """
    offsets = [k / (2 * (N_OFFSETS - 1)) for k in range(N_OFFSETS)]
    readings = [_read_off(offset, padding) for offset in offsets]
    per_line = steepest_db_per_hz * log(10) / 20 / duration_s
    return max(abs(height - 1) + per_line * abs(away) / padding for height, away in readings)


def padding_for(error: float, duration_s: float, steepest_db_per_hz: float, n: int = 1) -> int:
    """Return the smallest padding of `n` samples within an error, or the most.

    >>> padding_for(1e-4, 1.0, steepest_db_per_hz=0.69) <= 8, padding_for(1e-9, 1.0, 0.69)
    (True, 64)
    """
    fits = [padding for padding in PADDINGS if padding * n <= MOST_LINES] or PADDINGS[:1]
    return next((padding for padding in fits if peak_error(padding, duration_s, steepest_db_per_hz) <= error), fits[-1])


def size(demand: Demand) -> Size:
    """Return the padding at which the components of a record are read."""
    n = demand.once(samples)
    padding, error = _padding(demand, n)
    return Size({"padding": padding}, error, n_operations=300.0 * padding * n)


def size_of_record(demand: Demand) -> Size:
    """Return the padding for a played voltage of unknown length."""
    padding, error = _padding(demand)
    return Size({"padding": padding}, error)


def _padding(demand: Demand, n: int = 1) -> tuple[int, float]:
    duration_s, steepest_db_per_hz = demand.surface.duration_s, content_of(demand).steepest_db_per_hz
    padding = padding_for(demand.error, duration_s, steepest_db_per_hz, n)
    return padding, peak_error(padding, duration_s, steepest_db_per_hz)


def components_of(t_s: "FloatArray", record: "FloatArray", padding: int) -> "Components":
    """Return the components of a record (n_samples,), without its mean."""
    # the last sample belongs to the next period of the transform
    return components(record[:-1], (record.size - 1) / float(t_s[-1]), padding)


def _read_off(offset: float, padding: int) -> tuple[float, float]:
    """Return peak height and place read by a parabola, `offset` from a line."""
    before, at, after = (log(_transform((offset + k) / padding) / WINDOW[0]) for k in (1, 0, -1))
    away = (before - after) / (2 * (before - 2 * at + after))
    return exp(at - (before - after) * away / 4), away - offset


def _transform(lines: float) -> float:
    """Return the window's Fourier transform `lines` from its centre."""

    def sinc(x: float) -> float:
        return 1.0 if x == 0 else sin(pi * x) / (pi * x)

    sides = [WINDOW[k] / 2 * (sinc(lines - k) + sinc(lines + k)) for k in range(1, len(WINDOW))]
    return WINDOW[0] * sinc(lines) + sum(sides)


def resting(signal: Signal) -> Signal:
    """Return the transducer channels up to their last nonzero sample."""
    foci = signal.samples[:-1]
    n_driven = int(np.flatnonzero(np.any(foci, axis=0)).max(initial=0)) + 1
    return Signal(foci[:, :n_driven], signal.rate_hz, signal.unit)


def sliding(signal: Signal) -> Signal:
    """Return the electrode channel."""
    return Signal(signal.samples[-1:], signal.rate_hz, signal.unit)


def stronger(foci_db: FloatArray, friction_db: float) -> float:
    """Return the higher of the levels of the foci and the friction."""
    return max(float(np.max(foci_db)), friction_db)
