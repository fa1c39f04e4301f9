"""Progress of a session, computed from its journal, for terminal and page.

`Progress` is a fold: `after` accepts the next request with its answer, `after_event` the next event. `PartAhead`
describes a planned part.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from statistics import median
from typing import Any, Final

from ..trials.trial import Key, Reason, Tally, Trial, without
from .answer import Adjusted, Chosen, Done, Played, Touched
from .event import Event, missed_text
from .request import MISSED_PRACTICE, Choose, Fact, Intervene, Press, Record, Request, Show, Slide

TURNING: Final = frozenset(("staircase", "weighted_staircase"))
"""Procedures with reversals."""
MOST_SHOWN: Final = 12
"""Number of recent touches kept for display."""
COUNTS: Final = ("block", "n_blocks", "part", "n_parts", "n_questions")
"""Values shown on the page before a part, in addition to its factors."""
LAST_PAGES: Final = ("end", "declined")
"""Last pages of a completed session and of a declined consent."""
MOST_INTERVALS: Final = 20
"""Number of recent trials from which the pace is computed."""
LONGEST_INTERVALS: Final = 5
"""Multiple of the planned trial duration above which an interval counts as a pause."""
NEAR: Final = 2
"""Number of presentations before an abort at which a warning appears."""

TrackKey = tuple[int, str | None]
"""Number of a block, and name of an interleaved track."""


@dataclass(frozen=True)
class PartAhead:
    """Planned part of a session.

    Contains its factors, the largest number of trials, the longest duration (s), and the number of consecutive
    invalid presentations that aborts a track.
    """

    factors: Mapping[str, float | str] = field(default_factory=dict)
    n_trials: int = 0
    lasts_s: float = 0.0
    n_attempts: int | None = None


@dataclass(frozen=True)
class AnsweredTouch:
    """Requested touch and its answer. A level of None is a blank."""

    request: Press | Slide
    answer: Touched


@dataclass(frozen=True)
class TrackProgress:
    """Presentations of a track, one row each.

    `n_invalid_in_a_row` counts the invalid presentations since the last valid one.
    """

    presented: tuple[Trial, ...] = ()
    n_invalid_in_a_row: int = 0
    aborted: bool = False

    def after(self, trial: Trial, *, aborted: bool) -> "TrackProgress":
        """Add a row. Later rows of the same presentation do not count."""
        if self.presented and self.presented[-1].key == trial.key:
            return replace(self, aborted=self.aborted or aborted)
        n_in_a_row = 0 if trial.valid else self.n_invalid_in_a_row + 1
        return TrackProgress((*self.presented, trial), n_in_a_row, self.aborted or aborted)

    def without(self, retracted: Collection[Key]) -> "TrackProgress":
        """Mark retracted trials."""
        return replace(self, presented=without(self.presented, retracted))

    @property
    def answered(self) -> tuple[Trial, ...]:
        """Presentations that the rule used: valid ones, without catch trials."""
        return tuple(trial for trial in self.presented if trial.valid and trial.level is not None)

    @property
    def reversals(self) -> tuple[Trial, ...]:
        """Trials at which the levels of a staircase changed direction."""
        result: list[Trial] = []
        last, direction = None, 0.0
        for trial in (trial for trial in self.answered if trial.procedure in TURNING):
            if last is not None and last.level is not None and trial.level is not None:
                step = trial.level - last.level
                if step * direction < 0:
                    result.append(last)
                direction = step or direction
            last = trial
        return tuple(result)

    @property
    def n_attempts(self) -> int:
        return self.presented[-1].attempt if self.presented else 0

    @property
    def n_lost(self) -> int:
        """Invalid presentations that count towards an abort, in a row or of one trial."""
        return max(self.n_invalid_in_a_row, self.n_attempts) if self.n_invalid_in_a_row else 0

    def warning(self, n_attempts: int | None) -> str | None:
        """Return a warning if the track will soon be aborted."""
        n_left = 0 if n_attempts is None else n_attempts - self.n_lost
        if self.aborted or not self.n_lost or not 0 < n_left <= NEAR:
            return None
        whose = "the last touch" if self.n_lost == 1 else f"the last {self.n_lost} touches"
        in_a_row = f"{whose} did not count"
        of_one = f"one trial did not count in {self.n_attempts} attempts"
        lost = in_a_row if self.n_invalid_in_a_row >= self.n_attempts else of_one
        return f"{lost}: {n_left} more abort{'s' if n_left == 1 else ''} this condition"


@dataclass(frozen=True)
class Progress:
    """State of a session.

    - `tally`: Numbers of presentations, of invalid presentations, and of answers to questionnaires.
    - `n_parts`, `part`: Number of parts, and the current part, from 1; 0 before the first.
    - `page`: Message of the last page.
    - `factors`: Current condition.
    - `tracks`: Tracks by block and name.
    - `last`: Last recorded row.
    - `at_s`: Latest known session time, s.
    - `trial_times_s`: Times at which the last trials were recorded, s.
    - `n_catch`, `n_false_alarms`: Number of valid catch trials, and of those answered with yes.
    - `n_touches`, `touches`: Number of requested touches, and the last touches.
    - `reasons`: Number of touches and answers that did not count, by reason.
    - `n_frames`, `n_dropped_frames`, `n_gaps`: Frames of the screen, dropped frames, and gaps in the output.
    - `timing`: Last and longest `gate_delay_s` and `key_to_record_s`, s.
    - `clocks`: Last clock facts of each device.
    - `paused`: Who or what paused the session.
    - `stopped`, `aborted`: Why the session was stopped, and which parts were aborted.
    - `interventions`: Results of interventions.
    """

    tally: Tally = field(default_factory=Tally)
    n_parts: int = 0
    part: int = 0
    page: str | None = None
    factors: Mapping[str, float | str] = field(default_factory=dict)
    tracks: Mapping[TrackKey, TrackProgress] = field(default_factory=dict)
    last: Trial | None = None
    at_s: float = 0.0
    trial_times_s: tuple[float, ...] = ()
    n_catch: int = 0
    n_false_alarms: int = 0
    n_touches: int = 0
    touches: tuple[AnsweredTouch, ...] = ()
    reasons: Mapping[str, int] = field(default_factory=dict)
    n_frames: int = 0
    n_dropped_frames: int = 0
    n_gaps: int = 0
    timing: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    clocks: Mapping[str, Mapping[str, Fact]] = field(default_factory=dict)
    paused: str | None = None
    stopped: tuple[str, ...] = ()
    aborted: tuple[str, ...] = ()
    interventions: tuple[str, ...] = ()

    def after(self, request: Request[Any], answer: object) -> "Progress":
        """Add a request and its answer."""
        match request, answer:
            case Record(trial, aborted), Done(at_s):
                return self._recorded(trial, aborted, at_s)
            case Intervene(), Done():
                return self._changed(request)
            case Choose(question), Chosen(option) if question == MISSED_PRACTICE:
                return replace(self, interventions=(*self.interventions, missed_text(option)))
            case Show(message, values), Done(at_s):
                return self._shown(message, values, at_s)
            case ((Press() | Slide()), Touched()):
                touch = AnsweredTouch(request, answer)
                reason: Reason | None = touch.answer.invalid_reason
                reasons = self.reasons if reason is None else {**self.reasons, reason: self.reasons.get(reason, 0) + 1}
                return replace(
                    self,
                    at_s=max(self.at_s, touch.answer.onset_s),
                    n_touches=self.n_touches + 1,
                    touches=(*self.touches, touch)[-MOST_SHOWN:],
                    reasons=reasons,
                    n_gaps=self.n_gaps + (touch.answer.n_gaps or 0),
                )
            case _, Played() | Adjusted():
                return replace(self, at_s=max(self.at_s, answer.onset_s), n_gaps=self.n_gaps + (answer.n_gaps or 0))
        return self

    def after_event(self, event: Event) -> "Progress":
        """Add an event."""
        state, facts = replace(self, at_s=max(self.at_s, event.at_s)), event.facts
        text = str(facts.get("text", ""))
        match event.kind:
            case "trial":
                return state._timed(facts)
            case "clock":
                return replace(state, clocks={**self.clocks, str(facts.get("device")): facts})
            case "pause":
                return replace(state, paused=text)
            case "resume":
                return replace(state, paused=None)
            case "stop":
                return replace(state, paused=None, stopped=(*self.stopped, text))
        return state

    def _recorded(self, trial: Trial, aborted: str | None, at_s: float) -> "Progress":
        state = replace(
            self,
            tally=self.tally.after(trial),
            part=trial.block,
            factors=trial.factors,
            last=trial,
            at_s=max(self.at_s, at_s),
            aborted=self.aborted if aborted is None else (*self.aborted, aborted),
        )
        is_new = state.tally.n_presented > self.tally.n_presented
        return state if trial.is_form else state._presented(trial, aborted, at_s, is_new=is_new)

    def _changed(self, request: Intervene) -> "Progress":
        """Apply an intervention. Retracted trials no longer count anywhere."""
        presented = [trial for track in self.tracks.values() for trial in track.presented]
        lost = [trial for trial in presented if trial.valid and trial.key in request.retracted]
        caught = [trial for trial in lost if trial.catch]
        return replace(
            self,
            tally=replace(self.tally, n_invalid=self.tally.n_invalid + len(lost)),
            tracks={key: track.without(request.retracted) for key, track in self.tracks.items()},
            last=None if self.last is None else without([self.last], request.retracted)[0],
            n_catch=self.n_catch - len(caught),
            n_false_alarms=self.n_false_alarms - sum(trial.response == 1 for trial in caught),
            interventions=(*self.interventions, request.said),
        )

    def _presented(self, trial: Trial, aborted: str | None, at_s: float, *, is_new: bool) -> "Progress":
        key = (trial.block, trial.track)
        track = self.tracks.get(key, TrackProgress())
        caught = is_new and trial.valid and bool(trial.catch)
        return replace(
            self,
            tracks={**self.tracks, key: track.after(trial, aborted=aborted is not None)},
            trial_times_s=(*self.trial_times_s, at_s)[-MOST_INTERVALS:] if is_new else self.trial_times_s,
            n_catch=self.n_catch + caught,
            n_false_alarms=self.n_false_alarms + (caught and trial.response == 1),
        )

    def _shown(self, message: str, values: Mapping[str, str | int | float], at_s: float) -> "Progress":
        state = replace(self, page=message, at_s=max(self.at_s, at_s))
        if "n_blocks" not in values:
            return state
        factors = {name: level for name, level in values.items() if name not in COUNTS}
        return replace(state, n_parts=int(values["n_blocks"]), part=int(values.get("block", 0)), factors=factors)

    def _timed(self, facts: Mapping[str, Fact]) -> "Progress":
        timing = dict(self.timing)
        for name in ("gate_delay_s", "key_to_record_s"):
            if isinstance(value := facts.get(name), int | float):
                timing[name] = (value, max(value, timing.get(name, (0.0, 0.0))[1]))
        n_frames, n_dropped = (int(facts.get(name) or 0) for name in ("n_frames", "n_dropped_frames"))
        return replace(
            self,
            timing=timing,
            n_frames=self.n_frames + n_frames,
            n_dropped_frames=self.n_dropped_frames + n_dropped,
        )

    @property
    def track(self) -> TrackProgress | None:
        return None if self.last is None else self.tracks.get((self.last.block, self.last.track))

    @property
    def over(self) -> bool:
        return self.page in LAST_PAGES

    def n_valid(self, part: int | None = None) -> int:
        """Return the valid presentations of one part or all, with catch trials."""
        return sum(
            trial.valid
            for (block, _), track in self.tracks.items()
            for trial in track.presented
            if part is None or block == part
        )

    def warning(self, parts: Sequence[PartAhead]) -> str | None:
        """Return a warning if the current track will soon be aborted."""
        ahead = parts[self.part - 1] if 0 < self.part <= len(parts) else PartAhead()
        is_left = self.last is None or self.last.block != self.part  # for example a skipped block
        return None if self.track is None or is_left else self.track.warning(ahead.n_attempts)

    def left_s(self, parts: Sequence[PartAhead]) -> float:
        """Return the longest remaining time (s), at the pace of the last trials."""
        if self.over:
            return 0.0
        number = max(self.part, 1)
        return sum(self._part_left_s(n, part) for n, part in enumerate(parts, 1) if n >= number)

    def _part_left_s(self, number: int, part: PartAhead) -> float:
        if not part.n_trials:
            return part.lasts_s
        n_left = max(part.n_trials - self.n_valid(number), 0) if number == self.part else part.n_trials
        planned_s = part.lasts_s / part.n_trials
        pairs = zip(self.trial_times_s, self.trial_times_s[1:], strict=False)
        intervals_s = [after - before for before, after in pairs if after - before < LONGEST_INTERVALS * planned_s]
        trial_lasts_s = median(intervals_s) if len(intervals_s) >= LONGEST_INTERVALS else planned_s
        return n_left * trial_lasts_s
