"""A session: blocks and questionnaires in their order."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from tactometry.arguments.require import of_kind
from tactometry.questionnaire import NOT_SAID, PREFER_NOT, SAY, ChoiceForm, ChoiceItem, Questionnaire
from tactometry.session.answer import Chosen, Done, Intervention, Rated
from tactometry.session.request import (
    ABOUT,
    AGAIN,
    CONSENT,
    END_SESSION,
    MISSED_LABELS,
    MISSED_PRACTICE,
    Choose,
    Enter,
    Record,
    Show,
)
from tactometry.session.run import Course
from tactometry.trials.tasks import FORM_TASK
from tactometry.trials.trial import Trial

from .block_state import PartCourse, Track
from .interventions import between_blocks, heard, hearing
from .tasks.rating import fill_in
from .tasks.task import Reply


class Part(Protocol):
    """A block or a questionnaire."""

    @property
    def instructions(self) -> str | None:
        """Message before the first part of this kind, or None."""

    @property
    def page(self) -> str:
        """Message before this part."""

    @property
    def factors(self) -> Mapping[str, float | str]: ...

    @property
    def tracks(self) -> tuple[Track, ...]: ...

    def course(self, number: int, first_trial: int, rng: np.random.Generator) -> PartCourse: ...


@dataclass(frozen=True)
class Inquiry:
    """Questionnaire or form of choices, whose items are rows of one trial.

    The page shows the levels of `factors`. The rows contain the levels of the `condition` that the answers refer to.
    An inquiry that is `first` precedes all stimuli. An inquiry `of_block` is skipped if its block had no valid
    touch. Raises `InvalidParameter` if `form` is of another type.
    """

    form: Questionnaire | ChoiceForm
    shuffled: bool = False
    factors: Mapping[str, float | str] = field(default_factory=dict)
    condition: Mapping[str, float | str] = field(default_factory=dict)
    first: bool = False
    of_block: bool = False

    instructions = None
    tracks = ()

    def __post_init__(self) -> None:
        of_kind("Inquiry", (Questionnaire, ChoiceForm), form=self.form)

    @property
    def page(self) -> str:
        return "questions_first" if self.first else "questions"

    def course(self, number: int, first_trial: int, rng: np.random.Generator) -> PartCourse:
        if isinstance(self.form, ChoiceForm):
            wanted = yield from self._choices(self.form, number, first_trial)
        else:
            replies = yield from fill_in(self.form, rng, shuffled=self.shuffled)
            wanted = yield from heard(Record(self._row(number, first_trial, reply)) for reply in replies)
        yield from between_blocks(wanted)
        return (), first_trial + 1

    def _choices(self, form: ChoiceForm, number: int, trial: int) -> Course[tuple[Intervention, ...]]:
        """Ask each question on a page, and record its answer before the next one."""
        wanted: tuple[Intervention, ...] = ()
        for item in form.items:
            reply = yield from reply_to(form, item)
            wanted += yield from heard([Record(self._row(number, trial, reply))])
        return wanted

    def _row(self, number: int, trial: int, reply: Reply) -> Trial:
        assert reply.answer is not None
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


def question_of(form: ChoiceForm, item: ChoiceItem) -> Choose:
    """Return the request of a question with its texts from `words_of`."""
    name = f"{ABOUT}{form.name}.{item.id}"
    if item.bounds is not None:
        return Choose(name, (1, NOT_SAID), (SAY, PREFER_NOT))
    labels = (*(f"{name}.{option.code}" for option in item.options), PREFER_NOT)
    return Choose(name, item.codes, labels)


def reply_to(form: ChoiceForm, item: ChoiceItem) -> Course[Reply]:
    """Ask a question and return its code or number, or no response."""
    question = question_of(form, item)
    chosen: Chosen = yield question
    if item.bounds is None:
        return Reply(chosen, float(chosen.option), item=item.id)
    if chosen.option == NOT_SAID:
        return Reply(chosen, item=item.id)
    number: Rated = yield Enter(question.question, *item.bounds)
    return Reply(number, number.value, item=item.id)


def words_of(form: ChoiceForm, language: str) -> dict[str, str]:
    """Return the texts of a form by name, with braces escaped."""
    words: dict[str, str] = {}
    for item in form.items:
        question = question_of(form, item)
        words[question.question] = item.prompt.get(language, "").replace("{", "{{").replace("}", "}}")
        labels = zip(item.options, question.labels, strict=False)  # without the label for no answer, shared by all
        words |= {label: item.category(option.code, language) for option, label in labels}
    return words


def _instructions(parts: Sequence[Part], number: int) -> Iterator[Show]:
    """Yield the instructions before the first part of a kind."""
    message = parts[number - 1].instructions
    if message is not None and message not in [part.instructions for part in parts[: number - 1]]:
        yield Show(message)


def _page(parts: Sequence[Part], number: int) -> Show:
    """Return the page before a part, with its number."""
    part = parts[number - 1]
    counts = {"block": number, "n_blocks": len(parts)}
    if isinstance(part, Inquiry):
        return Show(part.page, {**counts, "n_questions": len(part.form.items), **part.factors})
    counted = [n for n, other in enumerate(parts, 1) if other.page == "block"]
    at = {"part": sum(n <= number for n in counted), "n_parts": len(counted)}
    return Show(part.page, {**counts, **at, **part.factors})


def pages(parts: Sequence[Part]) -> Iterator[Show]:
    """Yield the pages of a session outside its parts."""
    yield Show("welcome", {"n_blocks": len(parts)})
    for number in range(1, len(parts) + 1):
        yield from _instructions(parts, number)
        yield _page(parts, number)
    yield Show("end")


def session(
    parts: Sequence[Part], rng: np.random.Generator, longest_s: float | None = None, *, consent: bool = False
) -> Course[tuple[Track, ...]]:
    """Run all parts with their pages, and return the tracks at their end.

    No part begins later than `longest_s` after the start. If `consent` is asked for, no part begins without it.
    """
    wanted: list[Intervention] = []
    begun: Done = yield Show("welcome", {"n_blocks": len(parts)})
    wanted += begun.interventions
    yield from between_blocks(begun.interventions)
    if consent and (yield from _declined(wanted)):
        yield from between_blocks((yield from heard([Show("declined")])))
        return tuple(replace(track, begun=False) for part in parts for track in part.tracks)
    tracks: list[Track] = []
    felt: list[Trial] = []
    trial = 1
    for number, part in enumerate(parts, 1):
        if _ends(wanted):
            tracks += [replace(track, begun=False) for track in part.tracks]
            continue
        if isinstance(part, Inquiry) and part.of_block and not felt:
            continue
        felt = felt if isinstance(part, Inquiry) else []
        at_s = yield from _opened([*_instructions(parts, number), _page(parts, number)], f"block {number}", wanted)
        if at_s is None:
            tracks += [replace(track, skipped=True) for track in part.tracks]
            continue
        # checked only between parts: a started part runs until it ends or times out
        if longest_s is not None and at_s - begun.at_s > longest_s:
            tracks += [replace(track, begun=False) for part in parts[number - 1 :] for track in part.tracks]
            break
        again = True
        while again:
            ended, trial = yield from hearing(part.course(number, trial, rng), wanted, felt)
            again = yield from _practises_again(ended, _page(parts, number), wanted)
        tracks += ended
    yield from between_blocks((yield from heard([Show("end")])))
    return tuple(tracks)


def _practises_again(tracks: Sequence[Track], page: Show, wanted: list[Intervention]) -> Course[bool]:
    """Ask how to continue after a failed practice. Return True to repeat it."""
    missed = [track.missed_practice for track in tracks]
    if _ends(wanted) or not any(rule and rule.on_miss == "ask" for rule in missed):
        return False
    chosen: Chosen = yield Choose(MISSED_PRACTICE, tuple(MISSED_LABELS), tuple(MISSED_LABELS.values()))
    if chosen.option == END_SESSION:
        wanted.append(Intervention("end"))
    if chosen.option != AGAIN:
        return False
    return (yield from _opened([page], "the repeated practice", wanted)) is not None


def _opened(pages: Sequence[Show], ahead: str, wanted: list[Intervention]) -> Course[float | None]:
    """Show pages. Return when the last was left, or None if all is skipped."""
    at_s = 0.0
    for page in pages:
        shown: Done = yield page
        wanted += shown.interventions
        at_s = shown.at_s
        if (yield from between_blocks(shown.interventions, ahead)):
            return None
    return at_s


def _declined(wanted: list[Intervention]) -> Course[bool]:
    """Ask for consent, which only the journal records. Return True for no."""
    if not _ends(wanted):
        more = yield from heard([Show("consent")])
        yield from between_blocks(more)
        wanted += more
    if _ends(wanted):
        return False
    chosen: Chosen = yield Choose(CONSENT, (0, 1), ("no", "yes"))
    return chosen.option == 0


def _ends(wanted: Sequence[Intervention]) -> bool:
    return any(intervention.wanted == "end" for intervention in wanted)
