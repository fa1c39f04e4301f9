"""Sound card as a sensor, through PortAudio (extra: audio)."""

import time
from dataclasses import dataclass

import numpy as np

from ...arguments.constraints import NotNegative, Positive, PositiveWhole, constrained
from ...errors import DeviceFailed, attempt, reason
from ..clock_map import ClockMap
from ..portaudio import FULL_SCALE, end_stream, library, refuse_default
from .reader import SampleBlock, SensorSettings, Source


@dataclass(frozen=True)
@constrained
class AudioInputSettings(SensorSettings):
    """Sound card as a sensor, with counts as fractions of full scale.

    - `rate_hz`: Sampling rate of the sound card's input.
    - `device`: System name of the card.
    - `n_channels`: Number of channels to read, from the first.
    - `block_s`: Duration of a block.
    - `latency_s`: Duration that the card may buffer.
    """

    rate_hz: Positive
    device: str
    n_channels: PositiveWhole = 1
    block_s: Positive = 0.02
    latency_s: NotNegative = 0.1

    def __post_init__(self) -> None:
        refuse_default("AudioInputSettings", self.device)

    def source(self) -> "AudioInput":
        return AudioInput(self)


class AudioInput(Source):
    """Blocks from a card, whose time stamps are based on its frame count."""

    def __init__(self, settings: AudioInputSettings) -> None:
        super().__init__(f"audio {settings.device}", settings.rate_hz, settings.n_channels)
        self._settings = settings
        self._n_overruns = self._n_frames = 0
        self._clocks = ClockMap()

    def facts(self) -> dict[str, str | int | float | None]:
        return {"n_overruns": self._n_overruns, "clock_offset_s": self._clocks.offset_s}

    def open(self) -> None:
        sounddevice, settings = library(), self._settings
        problem = f"cannot record {settings.n_channels} channels at {settings.rate_hz:g} Hz"
        with attempt(
            self.name, problem, "an input that supports this format", (sounddevice.PortAudioError, ValueError)
        ):
            self._stream = sounddevice.InputStream(
                device=settings.device,
                channels=settings.n_channels,
                samplerate=settings.rate_hz,
                dtype="int32",
                latency=settings.latency_s,
                dither_off=True,
            )
            self._opened.callback(end_stream, self._stream, self.name)
            self._stream.start()
        self._clocks, self._n_frames = ClockMap(), 0

    def receive(self) -> SampleBlock | None:
        try:
            frames, overrun = self._stream.read(round(self._settings.block_s * self.rate_hz))
        except library().PortAudioError as error:
            raise DeviceFailed(f"{self.name}: the card was disconnected ({reason(error)})") from None
        self._n_overruns += bool(overrun)
        count_s = (self._n_frames + np.arange(1, len(frames) + 1)) / self.rate_hz
        self._n_frames += len(frames)
        self._clocks = self._clocks.after(float(count_s[-1]), time.perf_counter())
        self._clocks.check(self.name)
        offset_s = self._clocks.ours_s(0.0)
        return SampleBlock(count_s + offset_s, frames.astype(np.float64) / FULL_SCALE["int32"])
