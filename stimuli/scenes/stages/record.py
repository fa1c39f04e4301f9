"""What an electrode is given, sample by sample: the voltage of a signal that is played, and what follows from it.

A signal is taken as it is played, straight from sample to sample, so that any waveform is felt alike.
"""

from typing import TYPE_CHECKING

import numpy as np

from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ...composition.effect import Demand, Size
from ...composition.record import VoltageRecord
from ...perception.channels import heard
from ...perception.detection import Components, components
from .spectrum import padding_for, peak_error

if TYPE_CHECKING:
    from tactometry.signal import Signal

    from ...electrovibration.attraction.force import ForceForm
    from ...electrovibration.skin.skin import Skin
    from ...electrovibration.waveforms.pieces import Pieces

FINER = 2
Tissue = tuple[float, ...]


def recorded(signal: "Signal", share: float) -> VoltageRecord:
    """The voltage of a signal, `FINER` times as many samples (band-limited) where more than a share of its power lies
    above a quarter of the rate.

    The force goes with the square, which has twice the bandwidth: that of a carrier of 9.9 kHz at 20 kHz would seem to
    vibrate at 200 Hz.

    Raises
    ------
    InvalidParameter
        If the signal is not one channel in volt.
    """
    if signal.unit != "V" or len(signal.samples) != 1:
        raise InvalidParameter(
            f"signal: found {len(signal.samples)} channels in {signal.unit!r}, expected one channel in volt ('V')"
        )
    (voltage_v,) = signal.samples
    lines, n = np.fft.rfft(voltage_v), voltage_v.size
    power = lines.real**2 + lines.imag**2
    if n < 4 or power[lines.size // 2 :].sum() <= share * power.sum():
        return VoltageRecord(voltage_v, signal.rate_hz)
    lines[n // 2 :] *= 1.0 if n % 2 else 0.5
    return VoltageRecord(FINER * np.fft.irfft(lines, n=FINER * n), FINER * signal.rate_hz)


def sampling(demand: Demand) -> Size:
    """What aliases is fainter than the rest by the tolerated error: a share of the power that is its square."""
    return Size({"share": demand.error**2}, demand.error)


def reading(demand: Demand) -> Size:
    """How finely components are read off the record; it refuses what no record is long enough for."""
    from ...composition.sampling import content_of

    duration_s, steepest_db_per_hz = demand.surface.duration_s, content_of(demand).steepest_db_per_hz
    padding = padding_for(demand.error, duration_s, steepest_db_per_hz)
    return Size({"padding": padding}, peak_error(padding, duration_s, steepest_db_per_hz))


def skin(tissue: Tissue, **layers: float) -> "Skin":
    """The layers of a surface, and deeper tissue where there is any."""
    from ...electrovibration.skin.skin import Skin
    from ...electrovibration.skin.stack import Layer

    return Skin(**layers, tissue=Layer(*tissue) if tissue else None)


def layer_voltage(record: VoltageRecord, form: "ForceForm") -> FloatArray:
    """What of the voltage lies across the layer of a law, exactly."""
    return form.relaxations.sampled(record.voltage_v, record.rate_hz)


def pieces(record: VoltageRecord) -> "Pieces":
    """The straight lines between the samples."""
    from ...electrovibration.waveforms.pieces import straight

    return straight(record.t_s, record.voltage_v)


def times(record: VoltageRecord) -> FloatArray:
    """When the samples are."""
    return record.t_s


def components_of(record: VoltageRecord, course: FloatArray, padding: int) -> Components:
    """The components of a course over the record that any channel of touch answers to."""
    return heard(components(course, record.rate_hz, padding))


def grown(parts: Components, area_m2: float, form_area_m2: float) -> Components:
    """The force under an area from that under another: what does not drive the body is in proportion."""
    return parts.times(area_m2 / form_area_m2)
