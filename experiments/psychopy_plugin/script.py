"""Run parts of a study in the window of a PsychoPy script."""

import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Self, TypeVar

import numpy as np

from tactometry.arguments.require import expect, one_of
from tactometry.protocols.procedures.procedure import Procedure
from tactometry.protocols.session import reply_to, words_of
from tactometry.protocols.tasks.rating import fill_in
from tactometry.protocols.tasks.task import Presentation, Reply, TrialOutcome
from tactometry.questionnaire import ChoiceForm, Questionnaire, shipped_choices, shipped_names
from tactometry.rigs.experimenter.terminal import ExperimenterTerminal
from tactometry.rigs.touch.touch import ConcurrentPlay
from tactometry.session.answer import Played, Touched
from tactometry.session.request import Play, Press, Slide
from tactometry.session.run import Course
from tactometry.trials.cells import cell as cell_text

from ..bench.bench_file import load_bench
from ..sessions.rig_kinds import equipment
from ..study.cells import WiredCell
from ..study.experiment import wire
from ..study.session_plan import key_of
from ..study.study_file import load
from ..study.task_table import choices_named, form_of
from .loop import Loop, of_reply

T = TypeVar("T")
SHOWN_CELLS = 3


class PauseTerminal(ExperimenterTerminal):
    """Terminal that prints why a session pauses, but not its trials."""

    def add(self, words: str) -> None:
        del words


class PsychoPyStudy:
    """Study and bench in a script's window, which is restored after each call.

    The limits of study and bench apply to the output, as in a session. Duty limits count from the start of the script.

    - `study`: Name of a built-in study, or path of a study file.
    - `bench`: Bench file. Without it, nothing is played and no force is measured.
    - `seed`: Seed of random draws (intervals, orders of levels).

    Raises
    ------
    InvalidFile, InvalidParameter
        If the study or bench is invalid.
    DeviceFailed
        If a device cannot be opened.
    """

    def __init__(
        self, window: Any, study: str | Path, bench: str | Path | None = None, *, seed: int | None = None
    ) -> None:
        from tactometry.rigs.bench import Bench
        from tactometry.rigs.texts import texts_in
        from tactometry.rigs.window import Window

        numbers, _ = load(os.fspath(study))
        self.experiment = wire(numbers, os.fspath(study))
        file = load_bench(None if bench is None else Path(bench))
        texts = texts_in(file.screen.language, self._words_in(file.screen.language))
        self._language, self._rng = file.screen.language, np.random.default_rng(seed)
        devices = equipment(self.experiment, file)
        terminal = PauseTerminal(None, sys.stderr)
        self._rig = Bench(Window.adopt(window), devices, texts, terminal=terminal)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Set the output to zero and close the devices. May be called again."""
        self._rig.close()

    def touch(self, level: float | None, **factors: float | str) -> Touched:
        """Guide the finger through a touch of a cell. Level None is blank.

        Raises `InvalidParameter` if the study has no such cell. Raises `Stopped` if Escape is pressed.
        """
        return self._rig.answer(self._touch_request(level, factors))

    def trial(self, level: float | None, **factors: float | str) -> TrialOutcome:
        """Run a trial of the study's task. An invalid touch gives no answer.

        Raises `InvalidParameter` or `Stopped` as for `touch`.
        """
        condition = self._cell(factors).condition
        shown = Presentation(condition.stimulus, level, condition.touch, condition.alternatives)
        return self._carry_out(self.experiment.task.trial(shown, self._rng))

    def begin(self, level: float | None, **factors: float | str) -> ConcurrentPlay:
        """Start a stimulus without a gate. Call `look` in each frame, then `end`."""
        return self._rig.begin(self._play_request(level, factors))

    def play(self, level: float | None, **factors: float | str) -> Played:
        """Play a stimulus to its end on a page of Tactometry."""
        return self._rig.answer(self._play_request(level, factors))

    def questionnaire(self, name: str, experiment: Any = None) -> dict[str, float | None]:
        """Show a questionnaire and return its answers by item (None: no answer).

        Answers to questions about a person (`demographics`, or ``kind = "choices"``) are the codes of categories. With
        the `experiment` handler of PsychoPy, each item adds a row: `NAME.item`, `NAME.response` and `NAME.category`.

        Raises `InvalidParameter` if the name is unknown, or the questionnaire has no texts in the language of the
        bench. Also if the questionnaire requests a number, which could identify a participant, and no inquiry for it
        has ``identifies = true``.
        """
        form = self._form(name)
        known = f"one of {', '.join(form.languages)}; choose that language on the bench, or add the words"
        expect(self._language in form.languages, f"questionnaire {name}", f"no words in {self._language!r}", known)
        answers: dict[str, float | None] = {}
        for reply in self._replies(form):  # each row is stored before the next question
            answers[reply.item or ""] = reply.response
            if experiment is not None:
                for column, value in of_reply(form, reply).items():
                    experiment.addData(f"{name}.{column}", value)
                experiment.nextEntry()
        return answers

    def _words_in(self, language: str) -> dict[str, str]:
        """Return the texts for participants, including unused choice forms."""
        study = self.experiment.study
        forms = (choices_named(study, name) for name in (*study.forms, *shipped_choices()))
        of_choices = {name: text for form in forms if form for name, text in words_of(form, language).items()}
        return of_choices | self.experiment.words_in(language)

    def _form(self, name: str) -> Questionnaire | ChoiceForm:
        study = self.experiment.study
        one_of("questionnaire", name, (*study.forms, *shipped_names(), *shipped_choices()))
        form = choices_named(study, name)
        if form is None:
            return form_of(study, name, "questionnaire")
        is_allowed = any(inquiry.form == name and inquiry.identifies for inquiry in study.inquiries.values())
        cure = "an inquiry for it with identifies = true, or questions with bands instead of numbers"
        found = f"{', '.join(form.numbers)}, which could identify a participant"
        expect(is_allowed or not form.numbers, f"questionnaire {name}", found, cure)
        return form

    def _replies(self, form: Questionnaire | ChoiceForm) -> Iterable[Reply]:
        if isinstance(form, ChoiceForm):
            return (self._carry_out(reply_to(form, item)) for item in form.items)
        return self._carry_out(fill_in(form, self._rng, shuffled=False))

    def procedure(self, **factors: float | str) -> Procedure:
        """Return the study's procedure in its initial state. It is immutable."""
        [procedure] = self._cell(factors).procedure.for_tracks([""], self._rng)
        return procedure

    def loop(self, name: str, **factors: float | str) -> Loop:
        """Return the study's procedure as a PsychoPy loop with this name."""
        return Loop(name, self.procedure(**factors), self.experiment.table.options.n_attempts)

    def _carry_out(self, course: Course[T]) -> T:
        """Carry out requests and return the result. The script records it."""
        answer: Any = None
        while True:
            try:
                request = course.send(answer)
            except StopIteration as end:
                value: T = end.value
                return value
            answer = self._rig.answer(request)

    def _touch_request(self, level: float | None, factors: dict[str, float | str]) -> Press | Slide:
        condition = self._cell(factors).condition
        request = condition.touch.request(condition.stimulus, level, None)
        assert not isinstance(request, Play)  # a study's touch is never without a gate
        return request

    def _play_request(self, level: float | None, factors: dict[str, float | str]) -> Play:
        gated = self._touch_request(level, factors)
        return Play(gated.stimulus, level, gated.duration_s)

    def _cell(self, factors: dict[str, float | str]) -> WiredCell:
        cells = self.experiment.cells
        key = key_of(factors) if factors or len(cells) > 1 else next(iter(cells))
        named = [", ".join(f"{name} = {cell_text(level)}" for name, level in of_cell) for of_cell in [key, *cells]]
        more = "" if len(cells) <= SHOWN_CELLS else f", ... ({len(cells)} cells)"
        expected = f"the factors of a cell: {'; '.join(named[1 : SHOWN_CELLS + 1])}{more}"
        expect(key in cells, "factors", named[0] or "none", expected)
        return cells[key]
