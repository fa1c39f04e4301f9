"""A rig whose participant is simulated, in simulated time."""

from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np

from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.force_gate import VALID_PART, compliance
from tactometry.limits import Limits
from tactometry.observers.finger import SimulatedFinger
from tactometry.observers.observer import Observer
from tactometry.request import (
    Adjust,
    Adjusted,
    Choose,
    Chosen,
    Done,
    Play,
    Played,
    Press,
    Rate,
    Rated,
    Record,
    Show,
    Slide,
    Touched,
    Wait,
)
from tactometry.signal import Signal, Stimulus


class Sensation(Protocol):
    """What a finger feels of a signal: a sensation level in dB re the detection threshold, -inf for nothing."""

    def sensation_db(self, signal: Signal, contact: Contact) -> float: ...


class SimulatedRig:
    """Answers as `observer` does from what `sensation` says that the skin receives.

    Everything random of trial n comes from `rng_of(n)`, so that a session that is resumed goes on as if it had never
    stopped. Limits are checked as on a bench.
    """

    def __init__(
        self,
        bank: Mapping[str, Stimulus],
        limits: Limits,
        sensation: Sensation,
        observer: Observer,
        finger: SimulatedFinger,
        rng_of: Callable[[int], np.random.Generator],
    ) -> None:
        self._bank = bank
        self._limits = limits
        self._sensation = sensation
        self._observer = observer
        self._finger = finger
        self._rng_of = rng_of
        self._now_s = 0.0
        self._rendered: dict[tuple[str, float], Signal] = {}
        self._begin_trial(0)

    def _begin_trial(self, n_trials: int) -> None:
        self._n_trials = n_trials
        self._rng = self._rng_of(n_trials)
        self._felt_db: list[float] = []

    def facts(self) -> dict[str, str | int | float | bool | None]:
        return {"rig": "simulated", "clock": "simulated"}

    def resume(self, n_trials: int, elapsed_s: float) -> None:
        self._now_s = elapsed_s
        self._begin_trial(n_trials)

    def close(self) -> None:
        pass

    def _signal(self, stimulus: str, level: float | None) -> Signal | None:
        if level is None:
            return None
        if (stimulus, level) not in self._rendered:
            self._rendered[stimulus, level] = self._bank[stimulus].at(level)
        signal = self._rendered[stimulus, level]
        self._limits.check(signal)
        return signal

    def _feel(self, signal: Signal | None, contact: Contact) -> None:
        self._felt_db.append(float("-inf") if signal is None else self._sensation.sensation_db(signal, contact))

    def _pass(self, duration_s: float) -> float:
        """The present time, which then passes by."""
        now_s = self._now_s
        self._now_s = round(now_s + duration_s, 9)
        return now_s

    def play(self, request: Play) -> Played:
        signal = self._signal(request.stimulus, request.level)
        self._feel(signal, Contact(0.0))
        onset_s = self._pass(request.duration_s)
        return Played(onset_s, request.level, "" if signal is None else signal.digest())

    def press(self, request: Press) -> Touched:
        return self._touch(request, 0.0)

    def slide(self, request: Slide) -> Touched:
        return self._touch(request, request.speed_m_per_s)

    def _touch(self, request: Press | Slide, speed_m_per_s: float) -> Touched:
        signal = self._signal(request.stimulus, request.level)
        grip = self._finger.hold(request.target_n, request.tolerance, speed_m_per_s, request.duration_s, self._rng)
        mean_n, sd_n, in_band = compliance(grip.times_s, grip.forces_n, request.target_n, request.tolerance)
        self._feel(signal, Contact(mean_n, grip.speed_m_per_s))
        self._pass(request.hold_s)
        return Touched(
            onset_s=self._pass(request.duration_s),
            level_delivered=request.level,
            digest=None if signal is None else signal.digest(),
            force_mean_n=round(mean_n, 6),
            force_sd_n=round(sd_n, 6),
            force_in_band=round(in_band, 6),
            speed_mean_m_per_s=round(grip.speed_m_per_s, 6),
            valid=in_band >= VALID_PART,
        )

    def choose(self, request: Choose) -> Chosen:
        if len(self._felt_db) == 1 and request.options == (0, 1):
            option = int(self._observer.detect(self._felt_db[0], self._rng))
        elif len(self._felt_db) == len(request.options):
            option = request.options[self._observer.compare(self._felt_db, self._rng)]
        else:
            raise InvalidParameter(
                f"the simulated participant was asked {request.question!r} with {len(request.options)} options after "
                f"{len(self._felt_db)} stimuli, expected one stimulus and (0, 1), or one stimulus for each option"
            )
        latency_s = round(self._observer.answer_time_s(self._rng), 6)
        return Chosen(option, self._pass(latency_s), latency_s)

    def rate(self, request: Rate) -> Rated:
        raise InvalidParameter(f"the simulated participant has no rule to rate {request.item!r}")

    def adjust(self, request: Adjust) -> Adjusted:
        raise InvalidParameter(f"the simulated participant has no rule to adjust {request.stimulus!r}")

    def wait(self, request: Wait) -> Done:
        self._pass(request.duration_s)
        return Done(self._now_s)

    def show(self, request: Show) -> Done:
        del request
        self._pass(2.0)
        return Done(self._now_s)

    def record(self, request: Record) -> Done:
        del request
        self._begin_trial(self._n_trials + 1)
        return Done(self._now_s)
