"""Stream of Lab Streaming Layer (extra: lsl)."""

import contextlib
import functools
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...arguments.constraints import Positive, PositiveWhole, constrained
from ...errors import DeviceFailed, attempt, library_needed
from ..clock_map import clock_offset_s
from .reader import POLL_S, SampleBlock, SensorSettings, Source

LONGEST_SEARCH_S = 5.0
OTHERS_WITHIN_S = 0.5
"""Time within which another outlet of the same name answers (unverified default)."""
MOST_OUTLETS = 100
MOST_SAMPLES = 4096
WARNINGS_ONLY = "[log]\nlevel = -1\n"
"""Settings that stop liblsl from printing to the terminal. They must be set before its first use."""
SETTINGS_FILES = ("lsl_api.cfg", "~/lsl_api/lsl_api.cfg", "/etc/lsl_api/lsl_api.cfg")


@dataclass(frozen=True)
@constrained
class LslSettings(SensorSettings):
    """Stream of Lab Streaming Layer, by the name of its outlet.

    - `stream`: Name of the outlet.
    - `rate_hz`: Sampling rate, equal to the rate in the header of the stream.
    - `n_channels`: Number of channels of the stream.
    - `source_id`: Identifier of one of several outlets with the same name. Without it the name must be unique.
    """

    stream: str
    rate_hz: Positive
    n_channels: PositiveWhole = 1
    source_id: str | None = None

    def source(self) -> "LslSource":
        return LslSource(self)


class LslSource(Source):
    """Inlet whose time stamps are converted to the local clock.

    If the outlet ends, `DeviceFailed` is raised. After that, only an outlet with the same source id is opened.
    """

    def __init__(self, settings: LslSettings) -> None:
        super().__init__(f"lsl {settings.stream}", settings.rate_hz, settings.n_channels)
        self._settings, self._source_id = settings, settings.source_id
        self._inlet: Any = None
        self._correction_s: float | None = None
        self._offset_s = 0.0
        self._searched = False

    def facts(self) -> dict[str, str | int | float | None]:
        # LSL compares clocks in the background every few seconds; the last correction is available at once
        inlet, pylsl = self._inlet, _library()
        if inlet is not None:
            with contextlib.suppress(pylsl.util.LostError, pylsl.util.TimeoutError, pylsl.util.InternalError):
                self._correction_s = inlet.time_correction(timeout=POLL_S)
        offset_s = None if self._correction_s is None else self._correction_s + self._offset_s
        return {"source_id": self._source_id, "clock_offset_s": offset_s}

    def open(self) -> None:
        pylsl = _library()
        info = self._find_outlet(pylsl)
        of_outlet = {"n_channels": info.channel_count(), "rate_hz": info.nominal_srate()}
        for name, value in of_outlet.items():
            expected = getattr(self._settings, name)
            if value != expected:
                raise DeviceFailed(
                    f"{self.name}: found a stream with {name} {value:g}, expected {expected:g}; correct the bench file"
                )
        # recover=False: raise when an outlet ends, as liblsl would wait for it silently
        inlet = pylsl.StreamInlet(info, max_buflen=60, recover=False, processing_flags=pylsl.proc_clocksync)
        lost = pylsl.util.LostError, pylsl.util.TimeoutError
        with attempt(self.name, "the outlet does not answer", "one that runs", lost):
            inlet.open_stream(timeout=LONGEST_SEARCH_S)
            self._correction_s = inlet.time_correction(timeout=LONGEST_SEARCH_S)
            inlet.flush()  # drop old samples
        self._offset_s = clock_offset_s(pylsl.local_clock, 20)  # both are steady
        self._opened.callback(inlet.close_stream)
        self._inlet, self._source_id = inlet, self._source_id or info.source_id() or None

    def _find_outlet(self, pylsl: Any) -> Any:
        search_s = 1.0 if self._searched else LONGEST_SEARCH_S
        self._searched = True
        if not pylsl.resolve_byprop("name", self._settings.stream, timeout=search_s):
            raise DeviceFailed(f"{self.name}: found no such stream in {search_s:g} s, expected a running outlet")
        # search again: the first search ends with the first outlet that answers
        outlets = pylsl.resolve_byprop("name", self._settings.stream, MOST_OUTLETS, OTHERS_WITHIN_S)
        matching = [info for info in outlets if self._source_id in (None, info.source_id())]
        if len(matching) != 1:
            ids = ", ".join(sorted(repr(info.source_id()) for info in outlets))
            one = "one" if self._source_id is None else f"one with {self._source_id!r}"
            raise DeviceFailed(
                f"{self.name}: found outlets of this name with the source ids {ids}, expected {one}; state source_id "
                "in the bench file, and stop the other outlets"
            )
        return matching[0]

    def receive(self) -> SampleBlock | None:
        pylsl = _library()
        try:
            samples, stamps_s = self._inlet.pull_chunk(timeout=POLL_S, max_samples=MOST_SAMPLES, min_samples=1)
        except pylsl.util.LostError:
            raise DeviceFailed(f"{self.name}: the outlet has ended") from None
        if not stamps_s:
            return None
        return SampleBlock(np.array(stamps_s) + self._offset_s, np.array(samples, dtype=np.float64))


@functools.cache
def _library() -> Any:
    with library_needed("lsl: cannot load liblsl ({error}); pip install 'tactometry[lsl]'"):
        import pylsl
    # a settings file of the user has priority
    if "LSLAPICFG" not in os.environ and not any(Path(place).expanduser().is_file() for place in SETTINGS_FILES):
        with contextlib.suppress(NotImplementedError):
            pylsl.set_config_content(WARNINGS_ONLY)
    return pylsl
