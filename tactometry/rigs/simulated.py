"""Rig with a simulated participant, in simulated time."""

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from math import ceil, floor
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np

from ..arguments.require import expect, lookup
from ..contact import Contact
from ..observers.changes import Answer, Shift, Shifted
from ..observers.decisions import Decision, Felt, Observer
from ..observers.finger import Grip, SimulatedFinger, Touches
from ..observers.people import Feeling
from ..position_dependent import FollowsFinger, felt_under, straight_way
from ..safety.limits import Limits
from ..session.answer import Adjusted, Chosen, Done, Filled, Played, Rated, Touched
from ..session.request import (
    ABOUT,
    CONSENT,
    GO_ON,
    MISSED_PRACTICE,
    TRAJECTORY_M,
    Adjust,
    Choose,
    Enter,
    Facts,
    Fill,
    Play,
    Press,
    Record,
    Show,
    Slide,
    Wait,
    value_at,
)
from ..session.run import LiveRig
from ..signal import Signal, Stimulus
from ..trials.trial import Trial
from .emitter import render
from .touch_validity import broken_condition, compliance_fields

if TYPE_CHECKING:
    from ..observers.raters import Rater


class Sensation(Protocol):
    """Model of a finger.

    Returns the sensation level of a signal in dB re the detection threshold, -inf if nothing is felt.
    """

    def sensation_db(self, signal: Signal, contact: Contact) -> float: ...


@runtime_checkable
class OfFingers(Sensation, Protocol):
    """Model of several fingers."""

    def fingers_db(self, signal: Signal, contact: Contact) -> tuple[float, ...]: ...


READING_S = 2.0
AS_IT_IS = Feeling()

Meeting = tuple[str, float, float]
"""Contact conditions of a cell: stimulus, requested force (N) and speed (m/s), 0 if not requested."""


def meeting(stimulus: str, request: Play | Press | Slide | Adjust) -> Meeting:
    """Return the contact conditions of a request with any stimulus name."""
    force_n, speed_m_per_s = getattr(request, "target_n", None), getattr(request, "speed_m_per_s", None)
    return stimulus, force_n or 0.0, speed_m_per_s or 0.0


def value_of(liking: float, scale: Fill) -> float:
    """Convert a liking from -1 to 1 to an answer on a scale."""
    fraction = (1 + liking) / 2
    if scale.steps is None:
        return round(scale.low + fraction * (scale.high - scale.low), 3)
    return value_at(round(fraction * (scale.steps - 1)), scale.steps, scale.low, scale.high)


Rendering = Callable[[str, float], Signal]
"""Function that returns the final samples of a stimulus and level."""
N_SIGNALS = 128


def rendering(bank: Mapping[str, Stimulus], limits: Limits) -> Rendering:
    """Render and check signals, caching the last `N_SIGNALS`."""
    return functools.lru_cache(N_SIGNALS)(lambda stimulus, level: render(bank, stimulus, level, limits))


@dataclass(eq=False)
class SimulatedRig(LiveRig):
    """Rig whose `observer` answers from what `sensation` computes.

    It checks the limits as a bench does.

    - `decisions`: Decision rule of each question.
    - `by_stimulus`: Finger models for some stimuli, instead of `sensation`.
    - `felt`: Description of the models for the journal.
    - `rendered`: Signals shared by several sessions.
    - `feelings`: Deviations of this participant by cell.
    - `shift`: Change of this participant after the given trials and answers.
    - `rater`: Model that answers questionnaires. Without one, the liking of the strength does.
    - `rng_of`: Random generator of trial n, so that a resumed session continues unchanged.
    """

    bank: Mapping[str, Stimulus]
    limits: Limits
    _: KW_ONLY
    sensation: Sensation
    observer: Observer
    finger: SimulatedFinger
    rng_of: Callable[[int], np.random.Generator]
    decisions: Mapping[str, Decision]
    by_stimulus: Mapping[str, Sensation] = field(default_factory=dict)
    felt: str = ""
    rendered: Rendering | None = None
    feelings: Mapping[Meeting, Feeling] = field(default_factory=dict)
    shift: Callable[[int, Sequence[Answer]], Shift] | None = None
    rater: "Rater | None" = None

    def __post_init__(self) -> None:
        self._now_s = 0.0
        # checked once, as a protocol check takes as long as the computation
        self._following = {name for name, stimulus in self.bank.items() if isinstance(stimulus, FollowsFinger)}
        self._rendered = self.rendered or rendering(self.bank, self.limits)
        self._answers: list[Answer] = []
        self._touches = Touches(self.finger, self.rng_of)
        self._begin_trial(0)

    def _begin_trial(self, n_trials: int) -> None:
        self._n_trials = n_trials
        self._touches.begin(n_trials)
        self._observer = self.observer
        if self.shift is not None:
            assert isinstance(self.observer, Shifted)  # otherwise the study was refused
            self._observer = self.observer.shifted(self.shift(n_trials, self._answers))
        self._felt: list[Felt] = []
        self._met: Meeting | None = None

    @property
    def _rng(self) -> np.random.Generator:
        return self._touches.rng

    def facts(self) -> Facts:
        return {"rig": "simulated", "clock": "simulated", **({"felt": self.felt} if self.felt else {})}

    def resume(self, trials: Sequence[Trial], elapsed_s: float) -> None:
        self._now_s = elapsed_s
        self._answers = [trial.response for trial in trials]
        self._begin_trial(len(trials))

    def close(self) -> None:
        pass

    def _sense(self, request: Play | Press | Slide, contact: Contact, grip: Grip | None = None) -> str | None:
        """Compute the sensation of a stimulus and return its digest; None for a blank."""
        stimulus, level = request.stimulus, request.level
        self._met = meeting(stimulus, request)
        if level is None:
            self._felt.append(Felt(stimulus, float("-inf")))
            return None
        signal = self._rendered(stimulus, level)
        if grip is not None and stimulus in self._following:
            signal = felt_under(self.bank[stimulus], signal, grip.times_s, grip.positions_m)
        level_db = self._sensation_db(request, level, signal, contact)
        self._felt.append(Felt(stimulus, level_db, self._fingers(request, level, contact)))
        return signal.digest()

    def _fingers(
        self, request: Play | Press | Slide, level: float, contact: Contact
    ) -> Callable[[str], tuple[float, ...]] | None:
        """Return the levels at each finger, or None for a one-finger model."""
        if not issubclass(type(self._skin(request.stimulus)), OfFingers):
            return None

        def fingers_db(other: str) -> tuple[float, ...]:
            skin, feeling = self._skin(other), self._feeling(other, request)
            assert isinstance(skin, OfFingers)  # all alternatives are stimuli of one kind
            felt_db = skin.fingers_db(self._rendered(other, level), contact)
            return tuple(each_db + feeling.deviation_db for each_db in felt_db)

        return fingers_db

    def _skin(self, stimulus: str) -> Sensation:
        return self.by_stimulus.get(stimulus, self.sensation)

    def _feeling(self, stimulus: str, request: Play | Press | Slide | Adjust) -> Feeling:
        return self.feelings.get(meeting(stimulus, request), AS_IT_IS)

    def _sensation_db(
        self, request: Play | Press | Slide | Adjust, level: float, signal: Signal, contact: Contact
    ) -> float:
        skin, feeling = self._skin(request.stimulus), self._feeling(request.stimulus, request)
        return feeling.felt_db(level, lambda: skin.sensation_db(signal, contact))

    def _pass(self, duration_s: float) -> float:
        """Return the present time, then advance it by `duration_s`."""
        now_s = self._now_s
        self._now_s = round(now_s + duration_s, 9)
        return now_s

    def _play(self, request: Play) -> Played:
        digest = self._sense(request, Contact(0.0)) or ""
        return Played(self._pass(request.duration_s), request.level, digest)

    def _feel(self, request: Press | Slide) -> Touched:
        grip, force, speed = self._touches.touch(request)
        reason = broken_condition(request, force, speed)
        digest = self._sense(request, Contact(force.mean_n, grip.speed_m_per_s), grip)
        self._pass(request.hold_s)
        return Touched(
            onset_s=self._pass(request.duration_s),
            level_delivered=request.level,
            digest=digest,
            speed_mean_m_per_s=round(grip.speed_m_per_s, 6),
            valid=reason is None,
            invalid_reason=reason,
            n_gaps=None,
            positions_digest=None,
            **compliance_fields(force, speed),
        )

    def _choose(self, request: Choose) -> Chosen:
        if request.question == CONSENT:
            return Chosen(1, *self._timing(1))
        if request.question == MISSED_PRACTICE:
            return Chosen(GO_ON, *self._timing(1))
        if request.question.startswith(ABOUT):  # questions about the participant have equally likely answers
            return Chosen(int(self._rng.choice(request.options)), *self._timing(1))
        decision = lookup("question to the simulated participant", request.question, self.decisions)
        n_expected = decision.n_stimuli or len(request.options)
        where = f"{request.question!r} to the simulated participant, with {len(request.options)} options"
        expect(len(self._felt) == n_expected, where, f"{len(self._felt)} stimuli before it", f"{n_expected}")
        option = decision.decide(self._observer, self._felt, request, self._rng)
        return Chosen(option, *self._timing(1))

    def _timing(self, n_questions: int) -> tuple[float, float]:
        latency_s = round(sum(self._observer.answer_time_s(self._rng) for _ in range(n_questions)), 6)
        return self._pass(latency_s), latency_s

    def _enter(self, request: Enter) -> Rated:
        if request.question.startswith(ABOUT) and request.high is not None:
            return Rated(_whole_between(request.low, request.high, self._rng), *self._timing(1))
        value = max(self._observer.magnitude(self._last_db(), self._rng), request.low)
        return Rated(value if request.high is None else min(value, request.high), *self._timing(1))

    def _fill(self, request: Fill) -> Filled:
        if self.rater is None:
            places = [(-1 if question.reversed else 1) * self._liking() for question in request.questions]
        else:
            places = self.rater.answers(request, self._met, self._liking(), self._rng)
        values = tuple(value_of(place, request) for place in places)
        return Filled(values, *self._timing(len(values)))

    def _liking(self) -> float:
        return self._observer.liking(self._last_db(), self._rng)

    def _last_db(self) -> float:
        return self._felt[-1].level_db if self._felt else 0.0

    def _adjust(self, request: Adjust) -> Adjusted:
        """Step up until the stimulus is felt, or down until it is not."""
        begin_s, felt = self._now_s, self._feels(request, 0)
        step, n_steps = (-1 if felt else 1), 0
        while self._feels(request, n_steps) == felt and request.low <= request.level(n_steps + step) <= request.high:
            n_steps += step
            self._timing(1)
        return Adjusted(request.level(n_steps), begin_s, round(self._now_s - begin_s, 6))

    def _feels(self, request: Adjust, n_steps: int) -> bool:
        level = request.level(n_steps)
        signal = self._rendered(request.stimulus, level)
        contact = Contact(request.target_n or 0.0, request.speed_m_per_s or 0.0)
        way = straight_way(signal.duration_s, contact.speed_m_per_s, TRAJECTORY_M)
        signal = felt_under(self.bank[request.stimulus], signal, *way)
        return self._observer.detect(self._sensation_db(request, level, signal, contact), self._rng)

    def _wait(self, request: Wait) -> Done:
        self._pass(request.duration_s)
        return Done(self._now_s)

    def _show(self, request: Show) -> Done:
        self._pass(READING_S if request.duration_s is None else request.duration_s)
        return Done(self._now_s)

    def _record(self, request: Record) -> Done:
        self._answers.append(request.trial.response)
        self._begin_trial(self._n_trials + 1)
        return Done(self._now_s)


def _whole_between(low: float, high: float, rng: np.random.Generator) -> float:
    """Draw a whole number within bounds, or their middle if there is none.

    >>> _whole_between(18.0, 18.5, np.random.default_rng(1)), _whole_between(0.25, 0.75, np.random.default_rng(1))
    (18.0, 0.5)
    """
    first, last = ceil(low), floor(high)
    return float(rng.integers(first, last + 1)) if first <= last else (low + high) / 2
