"""Keeps what the sensors say while something is felt, and what was emitted where it followed the finger."""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np

from ...devices.sensors.streamed import StreamedSensor
from ...session.answer import Adjusted, Played, Touched, TracePart
from ...session.event import EventLog, TraceKind
from ..emitter import Emitter

A = TypeVar("A")


class Tracer:
    """From one request that is felt to the end of its answer; the sensors' own listeners hold the last minute.

    Parameters
    ----------
    sensors : mapping of TraceKind to StreamedSensor
        Those that are there, and are to be kept.
    emitter : Emitter or None
        Whose output is to be kept where it followed the finger; None: it is not.
    log : EventLog or None
        Where the samples are kept; None: nowhere.
    session_s : callable
        The time of the session of a stamp on `time.perf_counter`, s.
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
        """An answer; of what was felt with the places where its samples are kept.

        Raises
        ------
        DeviceFailed
            If the disk is full or fails.
        """
        if self._log is None or not isinstance(answer, Played | Touched | Adjusted):
            return answer
        parts = [self._measured(self._log, kind, sensor) for kind, sensor in self._sensors.items()]
        if not isinstance(answer, Adjusted):  # a level that is set plays on and on: what was emitted is no one signal
            parts.append(self._emitted(self._log, answer.digest))
        return replace(answer, trace=tuple(part for part in parts if part is not None))

    def _measured(self, log: EventLog, kind: TraceKind, sensor: StreamedSensor) -> TracePart | None:
        times_s, values = sensor.read()
        if times_s.size == 0:
            return None
        shift_s = self._session_s(0.0)
        return log.keep_trace(kind, np.column_stack([times_s + shift_s, values]), sensor.reader.source.rate_hz)

    def _emitted(self, log: EventLog, digest: str | None) -> TracePart | None:
        signal = self._emitter.followed(digest) if self._emitter and digest else None
        return None if signal is None else log.keep_trace("emitted", signal.samples.T, signal.rate_hz)
