"""Base class of rigs with an output, sensors, a clock and supervision."""

import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from ..devices.outputs.guarded import Guarded
from ..devices.outputs.output import RAMP_S
from ..devices.sensors.streamed import StreamedSensor
from ..errors import DeviceFailed, ended_by_signal
from ..position_dependent import FingerPath
from ..safety.limits import FORCE_PEAK_N, Limits
from ..session.answer import Adjusted, Done, Marked, Played, Touched
from ..session.event import TRACE_KINDS, EventLog, TraceKind
from ..session.request import A, Facts, Intervene, Play, Press, Request, Slide
from ..session.run import LiveRig
from ..signal import Signal, Stimulus
from ..trials.trial import Tally, Trial, tally
from .emitter import Emitter
from .experimenter.supervisor import Supervisor, utc_text
from .experimenter.terminal import ExperimenterTerminal
from .pages import layout
from .pages.page import Display
from .pages.presenter import Presenter
from .texts import Texts
from .touch.gated_samples import Release
from .touch.touch import ConcurrentPlay
from .touch.watchdog import TouchSetup

Felt = TypeVar("Felt", Played, Touched)


@dataclass(frozen=True)
class Equipment:
    """Devices of a rig, and the stimuli that it plays.

    - `bank`: Stimuli by the names used in requests.
    - `limits`: Limits of the study, checked in addition to those of the output.
    - `sensor`: Force sensor. Without one, force fields are None and every touch is valid.
    - `position`: Position sensor. Without one, the speed is not measured.
    - `ramp_s`: Duration of the ramps added to signals that do not begin and end at zero. 0 for one-bit outputs.
    - `release`: True if the force must leave its band between touches.
    - `facts`: Facts on the open devices for the journal, with their clocks.
    - `display_height_m`: Measured height of the display's image, m, for the moving cue of a slide.
    - `dry_run`: True if the participant practises the touch without a stimulus before the first trial.
    - `traces`: Kinds of samples to record of each touch.
    """

    output: Guarded
    bank: Mapping[str, Stimulus]
    limits: Limits | None = None
    sensor: StreamedSensor | None = None
    position: StreamedSensor | None = None
    ramp_s: float = RAMP_S
    release: bool = True
    facts: Callable[[], Facts] = dict
    display_height_m: float | None = None
    traces: Collection[TraceKind] = TRACE_KINDS
    dry_run: bool = False

    @property
    def traced(self) -> dict[TraceKind, StreamedSensor]:
        sensors: dict[TraceKind, StreamedSensor | None] = {"force": self.sensor, "position": self.position}
        return {kind: sensor for kind, sensor in sensors.items() if sensor is not None and kind in self.traces}


class DeviceRig(LiveRig):
    """Base rig that opens the devices and closes them on any failure.

    The output is closed first. `screen` belongs to the participant, `terminal` to the experimenter. `log` records
    pauses, remarks and stimuli.

    Raises `DeviceFailed` if a device does not open.
    """

    def __init__(
        self,
        screen: Display,
        equipment: Equipment,
        texts: Texts,
        *,
        terminal: ExperimenterTerminal | None = None,
        log: EventLog | None = None,
    ) -> None:
        self._screen, self._equipment, self._texts = screen, equipment, texts
        self._terminal = terminal = terminal or ExperimenterTerminal()
        limits, output = equipment.limits, equipment.output
        self._path = None if equipment.position is None else FingerPath()
        self._emitter = Emitter(equipment.bank, output, limits, equipment.ramp_s, self._path)
        names = {"experimenter": texts.label("experimenter")}
        paused, stopped = (
            layout.message_page(texts.message(name, names), "", screen.aspect) for name in ("pause", "stopped")
        )
        self._supervisor = Supervisor(screen, terminal, log, self._emitter.mute, paused, stopped)
        output.subscribe(self._supervisor.note_stimulus, self._supervisor.note_stimulus_end)
        self._presenter = Presenter(screen, self._supervisor.attend)
        self._setup = TouchSetup(
            presenter=self._presenter,
            emitter=self._emitter,
            sensor=equipment.sensor,
            position=equipment.position,
            release=Release(needed=equipment.release),
            pause=self._pause,
            say=terminal.say,
            force_peak_n=FORCE_PEAK_N if limits is None else limits.force_peak_n,
            keep_path=(lambda digest, lines: None) if log is None else log.keep_path,
        )
        followed = self._emitter if "emitted" in equipment.traces else None
        self._tracer = Tracer(equipment.traced, followed, log, self._session_s)
        self._keep_marks: Callable[[Marked], None] = (lambda marked: None) if log is None else log.keep_marks
        self._tally = Tally()
        self.closed = False
        with self._closed_on_failure():
            self._open()
            screen.give_back()

    def _open(self) -> None:
        # open the output last, so that it is not claimed if a sensor is missing
        for device in (self._equipment.position, self._equipment.sensor, self._equipment.output):
            if device is not None:
                device.open()
        if self._equipment.sensor is not None:
            self._equipment.sensor.subscribe(self._setup.release.on_samples)
        if self._path is not None and self._equipment.position is not None:
            self._equipment.position.subscribe(self._path.on_samples)

    @contextmanager
    def _closed_on_failure(self) -> Iterator[None]:
        """Close the rig, output first, if the body raises.

        Raises `DeviceFailed` if the rig is already closed, or if PsychoPy ends the program.
        """
        if self.closed:
            raise DeviceFailed("bench: found a closed bench, expected an open bench; open it again")
        try:
            yield
        except SystemExit as end:
            self.close()
            if ended_by_signal(end):
                raise
            raise DeviceFailed(
                f"window: PsychoPy ended the program (exit status {end.code}); continue with --resume"
            ) from end
        except BaseException:  # including Ctrl-C: nothing may play after a failed request
            self.close()
            raise

    def close(self) -> None:
        if self.closed:
            return
        self.closed = True
        # zero the output first: other devices may fail or hang; close all even if one fails
        with ExitStack() as last_first:
            last_first.callback(self._terminal.close)
            last_first.callback(self._screen.close)
            for sensor in (self._equipment.position, self._equipment.sensor):
                if sensor is not None:
                    last_first.callback(sensor.close)
            last_first.callback(self._equipment.output.close)
            last_first.callback(self._equipment.output.stop)

    def _device_facts(self) -> Facts:
        sensor, position = self._equipment.sensor, self._equipment.position
        return {
            "output": self._equipment.output.name,
            "force_sensor": None if sensor is None else sensor.name,
            "position_sensor": None if position is None else position.name,
            "traces": ", ".join(kind for kind in TRACE_KINDS if kind in self._equipment.traces) or None,
            **self._emitter.limit_facts(),
            **self._equipment.facts(),
        }

    def resume(self, trials: Sequence[Trial], elapsed_s: float) -> None:
        self._tally = tally(trials)
        self._supervisor.goes_on_with(trials)
        self._supervisor.zero_s = time.perf_counter() - elapsed_s

    def answer(self, request: Request[A]) -> A:
        with self._closed_on_failure():
            self._finish_trial()
            self._tracer.begin()
            answer = super().answer(request)
            self._screen.give_back()
            return self._tracer.kept(answer)

    def begin(self, request: Play) -> ConcurrentPlay:
        """Begin to play while the caller draws its own frames.

        Raises `DeviceFailed`, `InvalidParameter` or `LimitExceeded` if the stimulus cannot be played, and closes the
        rig.
        """
        with self._closed_on_failure():
            return ConcurrentPlay(self._setup, request, self._signal(request), self._screen.give_back)

    def _finish_trial(self) -> None:
        """Finish the current trial before the next request."""

    def _pause(self, by: str, over: Callable[[], bool]) -> None:
        self._supervisor.pause(by, over)
        self._presenter.end_pause()

    def _session_s(self, clock_s: float) -> float:
        return round(clock_s - self._supervisor.zero_s, 6)

    def _times(self, onset_s: float, end_s: float) -> tuple[float, float, str]:
        return self._session_s(onset_s), round(end_s - onset_s, 6), utc_text(end_s)

    def _done(self) -> Done:
        return Done(self._session_s(time.perf_counter()))

    def _done_between(self) -> Done:
        """Answer a request after which the experimenter's orders may take effect."""
        return replace(self._done(), interventions=self._supervisor.take_interventions())

    def _intervene(self, request: Intervene) -> Done:
        self._supervisor.carry_out(request)
        return self._done()

    def _signal(self, request: Play | Press | Slide) -> Signal | None:
        """Return the final samples, checked against all limits, or None for a blank."""
        if self._equipment.limits is not None and not isinstance(request, Play):
            self._equipment.limits.check_force(request.target_n, request.tolerance)
        return self._emitter.for_interval(request.stimulus, request.level, request.duration_s)

    def _in_session(self, felt: Felt) -> Felt:
        return replace(felt, onset_s=self._session_s(felt.onset_s))

    def _touched_in_session(self, touched: Touched) -> Touched:
        gate_s = None if touched.gate_s is None else self._session_s(touched.gate_s)
        return replace(self._in_session(touched), gate_s=gate_s)


class Tracer:
    """Recorder of sensor and output samples, from request to answer.

    - `sensors`: Sensors whose samples are recorded.
    - `emitter`: Source of the emitted signals that followed the finger, or None to record none.
    - `log`: Store of the samples, or None to record nothing.
    - `session_s`: Converts a time on `time.perf_counter` to session time, s.
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
        """Discard earlier sensor samples."""
        for sensor in self._sensors.values():
            sensor.read()

    def kept(self, answer: A) -> A:
        """Return the answer with references to its stored samples."""
        if self._log is None or not isinstance(answer, Played | Touched | Adjusted):
            return answer
        parts = []
        samples = {kind: sensor.read() for kind, sensor in self._sensors.items()}  # read all sensors at the same time
        for kind, (times_s, values) in samples.items():
            if len(times_s):
                table = np.column_stack([times_s + self._session_s(0.0), values])
                parts.append(self._log.keep_trace(kind, table, self._sensors[kind].reader.source.rate_hz))

        # an adjusted level plays repeatedly, so no single signal was emitted
        digest = None if isinstance(answer, Adjusted) else answer.digest
        signal = self._emitter.followed_signal(digest) if self._emitter and digest else None
        if signal is not None:
            parts.append(self._log.keep_trace("emitted", signal.samples.T, signal.rate_hz))
        return replace(answer, trace=tuple(parts))
