"""Keeps what the sensors say while something is felt, and what was emitted where it followed the finger."""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np

from ...devices.sensors.streamed import StreamedSensor
from ...session.answer import Adjusted, Played, Touched, TracePart
from ...session.event import EventLog, TraceKind
from ...signal import FloatArray
from ..emitter import Emitter

A = TypeVar("A")


class Tracer:
    """From one request that is felt to the end of its answer; the sensors' own listeners hold the last minute.

    - `sensors`: Those that are there, and are to be kept.
    - `emitter`: Whose output is to be kept where it followed the finger; None: it is not.
    - `log`: Where the samples are kept; None: nowhere.
    - `session_s`: The time of the session of a stamp on `time.perf_counter`, s.
    """

    def __init__(
        self,
        sensors: dict[TraceKind, StreamedSensor],
        emitter: Emitter | None,
        log: EventLog | None,
        session_s: Callable[[float], float],
    ) -> None:
        self._sensors, self._emitter, self._log, self._session_s = sensors, emitter, log, session_s

    def begin(self) -> None:
        """What the sensors said before does not belong to what is felt now."""
        for sensor in self._sensors.values():
            sensor.read()

    def kept(self, answer: A) -> A:
        """An answer; of what was felt with the places where its samples are kept."""
        if self._log is None or not isinstance(answer, Played | Touched | Adjusted):
            return answer
        tables = {kind: self._read(sensor) for kind, sensor in self._sensors.items()}  # all at once
        parts = [self._measured(self._log, kind, table) for kind, table in tables.items() if len(table)]
        if not isinstance(answer, Adjusted):  # a level that is set plays on and on: what was emitted is no one signal
            signal = self._emitter.followed(answer.digest) if self._emitter and answer.digest else None
            emitted = [] if signal is None else [self._log.keep_trace("emitted", signal.samples.T, signal.rate_hz)]
            parts += emitted
        return replace(answer, trace=tuple(parts))

    def _read(self, sensor: StreamedSensor) -> FloatArray:
        times_s, values = sensor.read()
        return np.column_stack([times_s + self._session_s(0.0), values])

    def _measured(self, log: EventLog, kind: TraceKind, table: FloatArray) -> TracePart:
        return log.keep_trace(kind, table, self._sensors[kind].reader.source.rate_hz)
