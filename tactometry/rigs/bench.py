"""Bench rig: a participant at a screen, with an output under the finger.

On Escape or any failure, the output is set to zero before any device is closed.
"""

import functools
import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from ..session.answer import Adjusted, Chosen, Done, Filled, Played, Rated, Touched
from ..session.request import ABOUT, Adjust, Choose, Enter, Facts, Fill, Play, Press, Record, Show, Slide, Wait
from ..trials.trial import Reason
from .device_rig import DeviceRig
from .experimenter.supervisor import CLOCK, TrialLog
from .pages import entry, form, layout
from .pages.page import Answer, Page
from .pages.presenter import Dress, as_it_is
from .touch.gated_samples import Trace
from .touch.touch import TouchRun, moving_cue
from .touch.watchdog import RepeatedStimulus, play_to_end, watchdog

S = TypeVar("S")
ASSUMED_DISPLAY_HEIGHT_M = 0.3
"""Assumed display height (24-inch display) for the moving cue of a slide, if none was measured (unverified default)."""
N_DRY_RUNS = 3
"""Largest number of practice touches without a stimulus (unverified default)."""
HINT_CONTINUE = "hint_continue"


class Bench(DeviceRig):
    """Rig for a human participant at a screen.

    If no display height was measured, a `Slide` assumes `ASSUMED_DISPLAY_HEIGHT_M`, and the journal records this.
    The log also contains the device clocks and the timing of each trial.
    """

    def _open(self) -> None:
        super()._open()
        self._trial_log = TrialLog(self._supervisor, self._screen, self._clocks)
        self._lost: Reason | None = None
        self._known: set[type[Press | Slide]] = set()
        # drawn in advance, so that the first page of a trial is not delayed
        for interval in (None, 1, 2):
            self._screen.prepare(layout.marker_page(interval, playing=True))
            self._screen.prepare(layout.marker_page(interval, playing=False))
        output = self._equipment.output
        if not output.emits:
            self._terminal.tell(f"output {output.name}: it plays nothing, so every level is recorded as not delivered")

    def facts(self) -> Facts:
        """Return facts on display, keyboard, devices and clock for the journal."""
        return {
            "rig": "bench",
            **self._screen.facts(),
            "display_height_m": self._equipment.display_height_m,
            **self._device_facts(),
            "clock": "time.perf_counter",
            "clock_resolution_s": time.get_clock_info("perf_counter").resolution,
            "utc_minus_clock_s": round(time.time() - time.perf_counter(), 6),
        }

    def _clocks(self) -> Facts:
        keyboard_s, utc_s = self._screen.clock_offset_s(), time.perf_counter() - time.time()
        return {**self._equipment.facts(), f"keyboard{CLOCK}": keyboard_s, f"utc{CLOCK}": utc_s}

    def _finish_trial(self) -> None:
        self._trial_log.finish_trial()

    def _play(self, request: Play) -> Played:
        page = layout.marker_page(request.interval, playing=True)
        return self._in_session(play_to_end(self._setup, request, page, self._signal(request)))

    def _feel(self, request: Press | Slide) -> Touched:
        if self._equipment.dry_run and type(request) not in self._known:
            self._dry_run(request)
        self._supervisor.under_way = True
        level = "blank" if request.level is None else f"{request.level:g}"
        self._terminal.add(f"trial {self._tally.n_presented + 1}: {request.stimulus} {level}")
        touch_run = self._touch_run(request, "" if self._lost is None else f"lost_{self._lost}")
        felt, gate_delay_s = touch_run.carry_out(self._signal(request))
        self._trial_log.note_decision(gate_delay_s)
        touched = self._touched_in_session(felt)
        if touched.valid and self._supervisor.repeat:
            return replace(touched, valid=False, invalid_reason="experimenter")
        return touched

    def _touch_run(self, request: Press | Slide, why: str) -> TouchRun:
        """Prepare a touch. `why` names the message shown below the instruction."""
        places, words = Trace(), "press"
        dress: Dress = as_it_is
        if isinstance(request, Slide):
            height_m = self._equipment.display_height_m or ASSUMED_DISPLAY_HEIGHT_M
            words, dress = "slide", moving_cue(request, height_m, places)
        measured = self._texts.message(words if self._setup.sensor is None else f"{words}_force")
        reason = self._texts.message(why) if why else ""
        return TouchRun(request, self._setup, places, measured, self._texts.message("release"), dress, reason)

    def _dry_run(self, request: Press | Slide) -> None:
        """Explain the touch screen and let the participant try a touch.

        No stimulus plays. The journal records the practice as an event, without a table row or samples.
        """
        self._known.add(type(request))
        begin_s = time.perf_counter()
        kind = type(request).__name__.lower()
        self._leave(self._picture(request, f"how_{kind}"))
        self._terminal.add(f"dry run ({kind})")
        touched, why = None, "dry_run"
        for _ in range(N_DRY_RUNS):
            touched, _ = self._touch_run(replace(request, level=None, interval=None), why).carry_out(None)
            if touched.valid:
                break
            why = f"lost_{touched.invalid_reason}"
        assert touched is not None
        reason = touched.invalid_reason
        result = f"{kind}: {'held' if reason is None else f'not held, {self._terminal.phrase(reason)}'}"
        self._supervisor.note("dry_run", text=result)
        self._terminal.end_line()
        self._terminal.tell(f"dry run, {result} ({time.perf_counter() - begin_s:.0f} s)")
        self._leave(self._message(Show(f"dry_run_{'held' if reason is None else 'lost'}"), HINT_CONTINUE))
        self._tracer.begin()

    def _picture(self, request: Press | Slide, words: str) -> Page:
        place = self._setup.position is not None
        parts = layout.parts_of(slides=isinstance(request, Slide), force=self._setup.sensor is not None, place=place)
        meanings = {part: self._texts.message(f"meaning_{part}") for part in parts}
        hint = self._texts.message(HINT_CONTINUE)
        return layout.picture_page(self._texts.message(words), meanings, hint, self._screen.aspect)

    def _leave(self, page: Page) -> None:
        self._presenter.converse(None, lambda state: page, lambda state, answer: (state, True))

    def _choose(self, request: Choose) -> Chosen:
        page_of = layout.list_page if request.question.startswith(ABOUT) else layout.question_page
        page = page_of(
            self._texts.message(request.question),
            request.options,
            [self._texts.label(label) for label in request.labels],
            self._texts.message("hint_choose"),
            self._screen.aspect,
        )
        first: Answer = request.options[0]
        option, timing = self._ask(first, lambda option: page, lambda option, answer: (answer, True))
        assert isinstance(option, int)
        return Chosen(option, *timing)

    def _ask(
        self, state: S, view: Callable[[S], Page], after: Callable[[S, Answer], tuple[S, bool]]
    ) -> tuple[S, tuple[float, float, str, bool]]:
        state, onset_s, end_s = self._presenter.converse(state, view, after)
        return state, self._timing(onset_s, end_s)

    def _timing(self, onset_s: float, end_s: float) -> tuple[float, float, str, bool]:
        """Return onset (session time), latency, time of day, and validity."""
        self._trial_log.note_answer(end_s)
        self._terminal.add(f"answered in {end_s - onset_s:.2f} s")
        return *self._times(onset_s, end_s), not self._supervisor.repeat

    def _enter(self, request: Enter) -> Rated:
        words, hint = self._texts.message(request.question), self._texts.message("hint_enter")
        low, high = request.low, request.high

        def view(typed: str) -> Page:
            ready = entry.value_of(typed, low, high) is not None
            return entry.entry_page(words, typed, hint, self._screen.aspect, ready=ready)

        typed, timing = self._ask("", view, lambda typed, key: entry.after(typed, key, low, high))
        return Rated(entry.value_of(typed, low, high), *timing)

    def _fill(self, request: Fill) -> Filled:
        page = form.Form(request, self._texts)
        marks, onset_s, end_s = self._presenter.converse(
            page.begun(),
            lambda marks: form.form_page(page, marks, self._screen.aspect),
            functools.partial(form.after, page),
            form.Keeping(page, self._keep_marks, self._session_s),
        )
        return Filled(page.values(marks), *self._timing(onset_s, end_s), back=marks.back)

    def _adjust(self, request: Adjust) -> Adjusted:
        page = layout.adjust_page(
            self._texts.message("adjust"), self._texts.message("hint_adjust"), self._screen.aspect
        )
        self._supervisor.under_way = True
        with watchdog(self._setup) as look:
            stimulus = RepeatedStimulus(request, self._emitter, look)
            n_steps, onset_s, end_s = self._presenter.converse(
                0, lambda n_steps: page, functools.partial(layout.steps_after, request), stimulus.keep_playing
            )
            self._emitter.stop()
        begun_s, latency_s, utc, counts = self._timing(onset_s, end_s)
        n_gaps = stimulus.n_gaps()
        return Adjusted(request.level(n_steps), begun_s, latency_s, utc, counts and not n_gaps, n_gaps)

    def _wait(self, request: Wait) -> Done:
        begin_s = self._presenter.screen.present(layout.waiting_page())
        self._presenter.hold(begin_s + request.duration_s, layout.waiting_page())
        return self._done()

    def _show(self, request: Show) -> Done:
        self._terminal.tell(f"page: {request.message}")
        self._lost = None  # the last touch no longer applies after a page
        if request.duration_s is None:
            self._leave(self._message(request, "hint_end" if request.message == "end" else HINT_CONTINUE))
            return self._done_between()
        n_seconds = math.ceil(request.duration_s)
        for left_s in range(n_seconds, 0, -1):
            page = self._message(request, "", left_s)
            shown_s = request.duration_s - n_seconds + 1 if left_s == n_seconds else 1.0
            self._presenter.hold(self._presenter.screen.present(page) + shown_s, page)
        return self._done_between()

    def _message(self, request: Show, hint: str, left_s: int = 0) -> Page:
        """Return a page of text with progress, and a countdown if it is timed."""
        block, n_blocks = (request.values.get(name) for name in ("block", "n_blocks"))
        progress = (block - 1) / n_blocks if isinstance(block, int) and isinstance(n_blocks, int) else None
        words = self._texts.page(request, left_s)
        below = self._texts.message(hint) if hint else ""
        image = self._texts.images.get(request.message)
        return layout.message_page(words, below, self._screen.aspect, progress, image)

    def _record(self, request: Record) -> Done:
        trial = request.trial
        self._supervisor.end_trial(trial)
        self._lost = trial.invalid_reason
        before, self._tally = self._tally, self._tally.after(trial)
        if self._tally.n_presented > before.n_presented:  # not for every item of a questionnaire
            response = "no answer" if trial.response is None else trial.response
            outcome = self._terminal.outcome(trial, self._tally.n_presented)
            self._terminal.add(outcome if trial.task == "rating" else f"{response}, {outcome}")
        self._terminal.end_line()
        if request.aborted:
            self._terminal.tell(f"! {request.aborted}")
        self._trial_log.begin_trial(trial)
        return self._done_between()
