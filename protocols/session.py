"""A session: blocks and questionnaires in their order."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from tactometry.arguments.require import of_kind
from tactometry.questionnaire import Questionnaire
from tactometry.session.answer import Done
from tactometry.session.intervention import Intervention
from tactometry.session.request import Record, Show
from tactometry.session.run import Course
from tactometry.trials.tasks import FORM_TASK
from tactometry.trials.trial import Trial

from .block_state import PartCourse, Track
from .interventions import between_blocks, heard, hearing
from .tasks.rating import fill_in
from .tasks.task import Reply


class Part(Protocol):
    """A block, or whatever else has a place in a session."""

    @property
    def instructions(self) -> str:
        """The message that says what to do, once for all parts of its kind."""

    @property
    def page(self) -> str:
        """The message before this part."""

    @property
    def factors(self) -> Mapping[str, float | str]: ...

    @property
    def tracks(self) -> tuple[Track, ...]: ...

    def course(self, number: int, first_trial: int, rng: np.random.Generator) -> PartCourse: ...


@dataclass(frozen=True)
class Inquiry:
    """A questionnaire on its own: a row for each item, all of one trial.

    Its page knows the names of `factors`; its rows hold the levels of `condition`, which its answers are about.

    Raises
    ------
    InvalidParameter
        If `form` is no questionnaire.
    """

    form: Questionnaire
    shuffled: bool = False
    factors: Mapping[str, float | str] = field(default_factory=dict)
    condition: Mapping[str, float | str] = field(default_factory=dict)

    instructions = "instructions_rating"
    page = "block"
    tracks = ()

    def __post_init__(self) -> None:
        of_kind("Inquiry", Questionnaire, form=self.form)

    def course(self, number: int, first_trial: int, rng: np.random.Generator) -> PartCourse:
        replies = yield from fill_in(self.form, rng, shuffled=self.shuffled)
        wanted = yield from heard(Record(self._row(number, first_trial, reply)) for reply in replies)
        yield from between_blocks(wanted)
        return (), first_trial + 1

    def _row(self, number: int, trial: int, reply: Reply) -> Trial:
        assert reply.answer is not None  # that of its page
        return Trial(
            block=number,
            trial=trial,
            factors={**self.factors, **self.condition},
            procedure=self.form.name,
            level=None,
            level_unit="",
            task=FORM_TASK,
            response=reply.response,
            onset_s=reply.answer.onset_s,
            latency_s=reply.answer.latency_s,
            timestamp_utc=reply.answer.timestamp_utc,
            item=reply.item,
            practice=False,
        )


def _instructions(parts: Sequence[Part]) -> Iterator[Show]:
    """What to do, once for all parts of a kind."""
    return map(Show, dict.fromkeys(part.instructions for part in parts))


def _page(parts: Sequence[Part], number: int, part: Part) -> Show:
    """The page before a part."""
    return Show(part.page, {"block": number, "n_blocks": len(parts), **part.factors})


def pages(parts: Sequence[Part]) -> Iterator[Show]:
    """Every page of a session but those within its parts."""
    yield Show("welcome", {"n_blocks": len(parts)})
    yield from _instructions(parts)
    yield from (_page(parts, number, part) for number, part in enumerate(parts, 1))
    yield Show("end")


def session(
    parts: Sequence[Part], rng: np.random.Generator, longest_s: float | None = None
) -> Course[tuple[Track, ...]]:
    """All parts in their order, with a page before each, the instructions first, and a last page: how all tracks ended.

    No part begins later than `longest_s` after the start.
    """
    wanted: list[Intervention] = []
    begun_s = yield from _begin(parts, wanted)
    tracks: list[Track] = []
    trial = 1
    for number, part in enumerate(parts, 1):
        if _ends(wanted):
            tracks += [replace(track, begun=False) for track in part.tracks]
            continue
        shown: Done = yield _page(parts, number, part)
        wanted += shown.interventions
        is_skipped = yield from between_blocks(shown.interventions, f"block {number}")
        # Between parts only: a part that has begun comes to its end, or to that of its own time.
        if longest_s is not None and shown.at_s - begun_s > longest_s:
            tracks += [replace(track, begun=False) for part in parts[number - 1 :] for track in part.tracks]
            break
        if is_skipped:
            tracks += [replace(track, skipped=True) for track in part.tracks]
            continue
        ended, trial = yield from hearing(part.course(number, trial, rng), wanted)
        tracks += ended
    yield from between_blocks((yield from heard([Show("end")])))
    return tuple(tracks)


def _begin(parts: Sequence[Part], wanted: list[Intervention]) -> Course[float]:
    """The first pages: when they were shown, s."""
    begun: Done = yield Show("welcome", {"n_blocks": len(parts)})
    wanted += begun.interventions
    wanted += yield from heard(_instructions(parts))
    yield from between_blocks(wanted)
    return begun.at_s


def _ends(wanted: Sequence[Intervention]) -> bool:
    return any(intervention.wanted == "end" for intervention in wanted)
