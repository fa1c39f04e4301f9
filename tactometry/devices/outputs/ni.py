"""Analogue outputs of National Instruments devices (extra: ni).

The driver was written for the documented interface of `nidaqmx` and checked against its signatures. It was **not run on
a device**.

Each signal is a finite generation from a buffer that ends at zero, so that the output becomes zero without a
command. A stop aborts the generation and writes zeros. If the process is killed during a signal, the driver aborts
the task and the last value may remain at the output. Devices with an idle state are set to idle at 0 V
(`idle_at_zero`). Other devices need a hardware watchdog, or an amplifier that is switched off by hand.
"""

import time
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...arguments.constraints import Positive, constrained
from ...arguments.require import expect
from ...errors import DeviceFailed, library_needed
from ...safety.limits import STOP_WITHIN_S
from ...signal import FloatArray, Signal
from ..clock_map import CLOSE_WITHIN_S, within
from .gain import Gain, SignalChain, required_gain
from .output import AmplifiedDriver


@dataclass(frozen=True)
@constrained
class NiSettings:
    """Analogue outputs of a National Instruments card.

    - `channels`: Physical names such as ``Dev1/ao0``, in the order of the signal's channels.
    - `rate_hz`: Sampling rate of the cards, and therefore of the stimulus.
    - `range_v`: Largest output voltage of the device, of either sign.
    - `idle_at_zero`: Set the idle state of the device to 0 V, if it has one.
    - `onboard_memory`: Play only from the memory of the card.
    - `reconstruction_filter`: False for a card without a filter, which keeps each value until the next sample. Peaks
      between samples are then not checked.
    """

    connected: ClassVar[bool] = True
    channels: tuple[str, ...]
    rate_hz: Positive
    range_v: Positive = 10.0
    idle_at_zero: bool = False
    onboard_memory: bool = False
    reconstruction_filter: bool = True

    def __post_init__(self) -> None:
        once = len(set(self.channels)) == len(self.channels) > 0
        expect(once, "NiSettings.channels", list(self.channels), "at least one channel, each once")

    def driver(self, gain: Gain | None) -> "NiOutput":
        return NiOutput(self, required_gain(gain, "output.gain"))

    def chain(self) -> SignalChain:
        first, *others = self.channels
        more = f" and {len(others)} more" if others else ""
        return SignalChain(f"ni {first}{more}, {self.range_v:g} V")


def connector_v(settings: NiSettings, gain: Gain, signal: Signal) -> FloatArray:
    """Return connector voltages (n_channels, n_samples + 1) that end at 0.

    Raises `DeviceFailed` if the device cannot reach these voltages.

    >>> signal = Signal(np.array([[100.0, -200.0]]), 1e3, "V")
    >>> connector_v(NiSettings(("Dev1/ao0",), 1e3), Gain(10.0, 20.0), signal).tolist()
    [[5.0, -10.0, 0.0]]
    """
    volts = gain.to_units(signal) * gain.volts_per_unit
    peak_v = np.max(np.abs(volts), initial=0.0)
    if peak_v > settings.range_v:
        raise DeviceFailed(
            f"output ni: found {peak_v:.6g} V at the connector, expected at most the range of "
            f"{settings.range_v:g} V; nothing was played"
        )
    # the connector keeps the last value of a generation
    return np.pad(volts, ((0, 0), (0, 1)))


class NiOutput(AmplifiedDriver):
    """Output with one finite task per signal, which ends by itself."""

    def __init__(self, settings: NiSettings, gain: Gain) -> None:
        super().__init__(f"ni {','.join(settings.channels)}", len(settings.channels), settings.rate_hz, gain)
        self._settings = settings
        self._task: Any = None
        self._is_open = False

    @property
    def identity(self) -> str:
        """Name of the card, as a finger may touch any of its electrodes."""
        return f"ni {self._settings.channels[0].partition('/')[0]}"

    @property
    def reconstructs(self) -> bool:
        return self._settings.reconstruction_filter

    @property
    def stop_delay_s(self) -> float:
        return STOP_WITHIN_S

    def open(self) -> None:
        self._zero()
        self._is_open = True

    def final(self, signal: Signal) -> Signal:
        volts = connector_v(self._settings, self._gain, signal)
        return Signal(volts * self._gain.amplifier_gain, signal.rate_hz, "V")

    def play(self, signal: Signal) -> float:
        if not self._is_open:
            raise DeviceFailed(f"output {self.name!r}: found a closed output, expected an open one; nothing was played")
        self._end_task()
        volts = connector_v(self._settings, self._gain, signal)
        try:
            self._task = start_task(volts, self._settings)
        except Exception as error:
            raise _refusal(self.name, error) from None
        return time.perf_counter()

    def stop(self) -> None:
        within(STOP_WITHIN_S, self.name, self._silence)

    def _silence(self) -> None:
        if self._end_task():
            self._zero()

    def close(self) -> None:
        self._is_open = False
        within(CLOSE_WITHIN_S, self.name, self._silence)

    def _end_task(self) -> bool:
        task, self._task = self._task, None
        if task is not None:
            task.close()
        return task is not None

    def _zero(self) -> None:
        """Write zero to every channel at once, without a clock."""
        try:
            with _library().Task() as task:
                _add_channels(task, self._settings)
                # nidaqmx takes a number for one channel, a list for several
                zeros: Any = [0.0] * self.n_channels if self.n_channels > 1 else 0.0
                task.write(zeros, auto_start=True)
        except DeviceFailed:
            raise
        except Exception as error:
            raise _refusal(self.name, error) from None


def start_task(volts: FloatArray, settings: NiSettings) -> Any:
    """Start a task that plays (n_channels, n_samples) volts once."""
    from nidaqmx.constants import AcquisitionType

    task = _library().Task()
    try:
        _add_channels(task, settings)
        task.timing.cfg_samp_clk_timing(
            rate=settings.rate_hz, sample_mode=AcquisitionType.FINITE, samps_per_chan=volts.shape[1]
        )
        task.write(volts if len(volts) > 1 else volts[0], auto_start=False)
        task.start()
    except BaseException:  # including Ctrl-C: an open task keeps its channels reserved
        task.close()
        raise
    return task


def _add_channels(task: Any, settings: NiSettings) -> None:
    from nidaqmx.constants import AOIdleOutputBehavior

    names, range_v = ",".join(settings.channels), settings.range_v
    added = task.ao_channels.add_ao_voltage_chan(names, min_val=-range_v, max_val=range_v)
    if settings.idle_at_zero:
        added.ao_idle_output_behavior = AOIdleOutputBehavior.ZERO_VOLTS
    if settings.onboard_memory:
        added.ao_use_only_on_brd_mem = True


def _library() -> Any:
    with library_needed(
        "output ni: found no nidaqmx; pip install 'tactometry[ni]' and install NI-DAQmx; nothing was played"
    ):
        import nidaqmx
    return nidaqmx


def _refusal(name: str, error: Exception) -> DeviceFailed:
    return DeviceFailed(f"output {name!r}: NI-DAQmx refused ({' '.join(str(error).split())}); nothing was played")
