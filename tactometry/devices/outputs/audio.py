"""Sound card as an output, through PortAudio (extra: audio)."""

import contextlib
import functools
import json
import subprocess
import time
from dataclasses import dataclass
from typing import Any, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray

from ...arguments.constraints import NotNegative, Positive, constrained
from ...arguments.require import at_most, expect
from ...errors import DeviceFailed
from ...position_dependent import FollowedSignal, PlayedPath
from ...signal import Signal
from ..clock_map import ClockMap
from ..portaudio import FULL_SCALE, end_stream, library, refuse_default
from .frame_feed import DryRuns, FollowingFeed, FrameFeed
from .gain import Gain, SignalChain, required_gain
from .output import LONGEST_WORD_S, AmplifiedDriver

FADE_S = 1e-3
"""Duration of the fade to zero at a stop, for any block size (unverified default)."""
LONGEST_START_S = 2.0
LONGEST_S: Final = {"block_s": 1.0, "latency_s": 10.0, "position_latency_s": 1.0}
"""Largest accepted settings. Longer times would delay stops and textures too much (unverified default)."""
POSITION_AGE_S: Final = 0.005
"""Age of the last finger position when it is used: sensor interval, transfer and thread switches (unverified
default)."""
WORD_S = 1e-3
SHARED: Final = ("pulse", "pipewire", "jack", "dmix")
SHARED_INTERFACES: Final = ("MME", "Windows DirectSound", "Windows WASAPI", "Core Audio", "JACK", "PulseAudio")
"""PortAudio devices and interfaces that mix in the sound of other programs."""
SERVERS: Final = ("pulse", "pipewire")
"""PortAudio devices on Linux that lead to the default sink of a sound server."""
ASKED_WITHIN_S: Final = 2.0


@dataclass(frozen=True)
@constrained
class AudioSettings:
    """Settings of a sound card, which is identified by name.

    Shorter `block_s` and `latency_s` stop sooner, longer ones avoid gaps in the sound. Both are unverified defaults.
    The default of `position_latency_s` is the longest recent lead of the device plus a block and `POSITION_AGE_S`.

    - `rate_hz`: Sampling rate of the card, and therefore of the stimulus.
    - `device`: System name of the card.
    - `channels`: Output channels of the card, from 0, in the order of the signal's channels.
    - `sample_format`: Format of the samples sent to the card.
    - `block_s`: Duration of a block. A stop takes at most a block and the latency.
    - `latency_s`: Duration of the buffer.
    - `shared`: Allow a device to which other programs play, too.
    - `position_latency_s`: Time from a finger position to the texture's voltage at this position. The default is
      computed from the recent lead of the device.
    """

    connected: ClassVar[bool] = True
    rate_hz: Positive
    device: str
    channels: tuple[int, ...] = (0,)
    sample_format: Literal["int16", "int32", "float32"] = "int32"
    block_s: Positive = 0.005
    latency_s: NotNegative = 0.05
    shared: bool = False
    position_latency_s: NotNegative | None = None

    def __post_init__(self) -> None:
        refuse_default("AudioSettings", self.device)
        for name, longest_s in LONGEST_S.items():
            at_most(f"AudioSettings.{name}", getattr(self, name) or 0.0, longest_s)
        frames = self.block_s * self.rate_hz
        expect(frames >= 1, "AudioSettings.block_s", f"{frames:.3g} samples", "at least one sample at rate_hz")
        once = len(set(self.channels)) == len(self.channels) > 0 and min(self.channels) >= 0
        outlets = "at least one channel, from 0, each once"
        expect(once, "AudioSettings.channels", list(self.channels), outlets)

    def driver(self, gain: Gain | None) -> "AudioOutput":
        return AudioOutput(self, required_gain(gain, "output.gain"))

    def chain(self) -> SignalChain:
        return SignalChain(f"audio {self.device}, {self.sample_format}", system_volume(self.device))


class AudioOutput(AmplifiedDriver):
    """Output stream that plays zeros, or the frames of one signal."""

    follows = True

    def __init__(self, settings: AudioSettings, gain: Gain) -> None:
        super().__init__(f"audio {settings.device}", len(settings.channels), settings.rate_hz, gain)
        self._settings = settings
        self._stream: Any = None
        self._device: str | None = None
        self._feed: FrameFeed | None = None
        self._n_frames, self._dry = 0, DryRuns(settings.latency_s)
        self._clocks = ClockMap()
        self._numbers = functools.lru_cache(maxsize=1)(self._round_to_zero)
        """Device samples, (n_channels, n_samples), cached for the last signal, so that `play` begins at once."""

    @property
    def identity(self) -> str:
        return f"audio {self._device}"

    def facts(self) -> dict[str, str | int | float | None]:
        latency_s = None if self._stream is None else self._stream.latency
        return {
            "device": self._device,
            "output_latency_s": latency_s,
            "position_latency_s": None if latency_s is None else round(self._position_latency_s(), 6),
            "n_underruns": self._dry.n_gaps,
            "clock_offset_s": self._clocks.offset_s,
        }

    @property
    def stop_delay_s(self) -> float:
        """Sum of buffered audio, a block and the fade, from recent reports of the card."""
        latency_s = 0.0 if self._stream is None else self._stream.latency
        buffered_s = max(self._settings.latency_s, latency_s, *list(self._dry.leads_s))
        return buffered_s + self._settings.block_s + self.fall_s

    @property
    def fall_s(self) -> float:
        return FADE_S

    def open(self) -> None:
        """Open the card and play zeros.

        Raises `DeviceFailed` if PortAudio or the device is missing, if the format is refused, or if other programs
        share the card and `shared` is not set.
        """
        sounddevice, settings = library(), self._settings
        if not settings.shared:
            _check_own(sounddevice, settings.device)
        self._n_frames, self._clocks = 0, ClockMap()
        try:
            self._stream = sounddevice.OutputStream(
                device=settings.device,
                # PortAudio opens outputs from the first on; unused ones get zeros
                channels=max(settings.channels) + 1,
                samplerate=settings.rate_hz,
                dtype=settings.sample_format,
                blocksize=round(settings.block_s * settings.rate_hz),
                latency=settings.latency_s,
                # emit exactly the bits that the guard checked in `final`
                dither_off=True,
                clip_off=True,
                callback=self._fill,
            )
            self._stream.start()
            self._device = str(sounddevice.query_devices(self._stream.device)["name"])
        except (sounddevice.PortAudioError, ValueError) as error:
            raise DeviceFailed(_why(sounddevice, settings, error)) from None

    def final(self, signal: Signal) -> Signal:
        full_scale = FULL_SCALE[self._settings.sample_format]
        return self._gain.to_volts(self._numbers(signal).astype(np.float64) / full_scale, signal.rate_hz)

    def _round_to_zero(self, signal: Signal) -> NDArray[np.generic]:
        """Round towards zero, so that rounding never exceeds a limit."""
        units = self._gain.to_units(signal)
        kind = np.dtype(self._settings.sample_format)
        if kind.kind == "i":
            return np.trunc(units * FULL_SCALE[kind.name]).astype(kind)
        # round to nearest, then one step back if that is further from zero
        numbers = units.astype(kind)
        return np.where(np.abs(numbers) > np.abs(units), np.nextafter(numbers, kind.type(0)), numbers)

    def play(self, signal: Signal) -> float:
        """Begin to play and return the onset that the card reports."""
        if self._stream is None or not self._stream.active:
            raise DeviceFailed(
                f"output {self.name!r}: found a closed or stopped device, expected an open device; nothing was played"
            )
        n_fade = max(1, round(FADE_S * self.rate_hz))
        numbers, channels = self._numbers(signal), self._settings.channels
        frames = np.zeros((numbers.shape[1], max(channels) + 1), numbers.dtype)
        frames[:, list(channels)] = numbers.T
        if isinstance(signal, FollowedSignal):
            feed: FrameFeed = FollowingFeed(frames, n_fade, signal, self._position_latency_s())
        else:
            feed = FrameFeed(frames, n_fade)
        if self._feed is not None and not self._feed.finished:
            self._feed.stop()
            if not self._feed.ended.wait(LONGEST_START_S):
                raise self._silent()
        self._feed = feed
        if signal.samples.size and not feed.begun.wait(LONGEST_START_S):
            feed.stop()
            raise self._silent()
        return feed.onset_s

    def _position_latency_s(self) -> float:
        """Return the time from a finger position to the resulting voltage.

        It contains the longest recent lead, because a sound server requests blocks in bursts.
        """
        stated_s, longest_lead_s = self._settings.position_latency_s, max(list(self._dry.leads_s), default=0.0)
        return longest_lead_s + self._settings.block_s + POSITION_AGE_S if stated_s is None else stated_s

    def played_path(self) -> PlayedPath | None:
        feed = self._feed
        if not isinstance(feed, FollowingFeed):
            return None
        feed.ended.wait(LONGEST_START_S)
        numbers = feed.frames()[:, list(self._settings.channels)].T
        full_scale = FULL_SCALE[self._settings.sample_format]
        volts = self._gain.to_volts(numbers.astype(np.float64) / full_scale, self.rate_hz)
        return PlayedPath(volts, feed.latency_s, feed.late, feed.unknown)

    def _silent(self) -> DeviceFailed:
        return DeviceFailed(f"output {self.name!r}: the device requested no samples in {LONGEST_START_S:g} s")

    def _fill(self, out: NDArray[np.generic], n_frames: int, times: Any, status: Any) -> None:
        now_s = time.perf_counter()
        feed = self._feed  # read once: `play` may replace it while this runs in PortAudio's thread
        lead_s = max(0.0, times.outputBufferDacTime - times.currentTime)
        block_s = n_frames / self.rate_hz
        underflow = bool(status.output_underflow)
        gap_s = self._dry.after(now_s=now_s, lead_s=lead_s, block_s=block_s, underflow=underflow)
        if feed is not None and gap_s is not None:
            feed.n_gaps += feed.is_torn_by(gap_s, self.rate_hz)
        self._clocks = self._clocks.after(self._n_frames / self.rate_hz, now_s)
        self._n_frames += n_frames
        out[:] = 0  # silence before a signal and after its last frame
        if feed is None or feed.finished:
            return
        if not feed.begun.is_set():
            feed.n_gaps += self._dry.is_dry  # the first frames are lost in the gap before them
            feed.begin(now_s, lead_s)
        # a device with unknown lead plays up to `latency_s` after its first block
        feed.give_up_if_late(self.rate_hz, FADE_S + (0.0 if self._dry.has_lead else self._settings.latency_s))
        piece = feed.take(n_frames)
        out[: len(piece)] = piece

    def n_gaps(self, longest_wait_s: float = LONGEST_WORD_S) -> int:
        """Return gaps since the last signal began, including a current one."""
        feed = self._feed
        if feed is None:
            return 0
        lasts = not self._asks_within(longest_wait_s) and feed.is_torn_by(self._dry.dry_s, self.rate_hz)
        # late frames imply at least one gap, even if none was reported
        return feed.n_gaps + lasts or int(feed.is_late(time.perf_counter(), self.rate_hz))

    def _asks_within(self, longest_s: float) -> bool:
        """Return True if the device requests samples in time."""
        n_frames, end_s = self._n_frames, time.perf_counter() + longest_s
        while longest_s and self._n_frames == n_frames:
            if time.perf_counter() > end_s:
                return False
            time.sleep(WORD_S)
        return True

    def stop(self) -> None:
        if self._feed is not None:
            self._feed.stop()

    def close(self) -> None:
        stream, self._stream = self._stream, None
        if stream is not None:
            end_stream(stream, self.name)


def _check_own(sounddevice: Any, device: str) -> None:
    """Refuse a device that other programs share."""
    try:
        card = sounddevice.query_devices(device, "output")
        interface = str(sounddevice.query_hostapis(card["hostapi"])["name"])
    except (sounddevice.PortAudioError, ValueError):
        return
    if card["name"] in SHARED or interface.startswith(SHARED_INTERFACES):
        raise DeviceFailed(
            f"output audio: found {card['name']!r} ({interface}), which other programs may use and whose volume "
            "they may change, expected a separate card, or shared = true in [output]; nothing was played"
        )


def _why(sounddevice: Any, settings: AudioSettings, error: Exception) -> str:
    wanted_format = f"{max(settings.channels) + 1} channels at {settings.rate_hz:g} Hz as {settings.sample_format}"
    try:
        known = ", ".join(
            repr(device["name"]) for device in sounddevice.query_devices() if device["max_output_channels"]
        )
    except sounddevice.PortAudioError:
        known = ""
    devices = f"the devices are {known}" if known else "the system has no output device"
    return (
        f"output audio: cannot open {settings.device} with {wanted_format} "
        f"({' '.join(str(error).split())}); {devices}; nothing was played"
    )


def system_volume(device: str) -> float | None:
    """Return the volume of a device's sink (1 for 100 %), or None.

    Only PulseAudio and PipeWire are queried. The result is the volume of the loudest channel.
    """
    if device not in SERVERS:
        return None
    with contextlib.suppress(OSError, subprocess.SubprocessError, ValueError, KeyError, IndexError):
        default = _pactl("info")["default_sink_name"]
        # no or several sinks of this name raise a ValueError, so the volume is unknown
        [sink] = [sink for sink in _pactl("list", "sinks") if sink["name"] == default]
        return _volume_of(sink)
    return None


def _volume_of(sink: Any) -> float:
    """Parse the volume of a sink from the output of ``pactl``.

    >>> _volume_of({"mute": False, "volume": {"left": {"value": 65536}, "right": {"value": 32768}}})
    1.0
    >>> _volume_of({"mute": True, "volume": {"mono": {"value": 65536}}})
    0.0
    """
    loudest = max(channel["value"] for channel in sink["volume"].values())
    return 0.0 if sink["mute"] else float(loudest) / 65_536


def _pactl(*arguments: str) -> Any:
    command = ["pactl", "--format=json", *arguments]
    answer = subprocess.run(command, capture_output=True, text=True, timeout=ASKED_WITHIN_S, check=True)
    return json.loads(answer.stdout)
