"""Dry run before the first touch of each kind."""

from dataclasses import replace

import pytest
from experimenter_seat import BLIP
from kept_events import Kept
from sampled import Passing

from tactometry.rigs.bench import N_DRY_RUNS
from tactometry.rigs.pages.page import Text
from tactometry.rigs.texts import texts_in
from tactometry.session.request import Press, Slide

PRESS = Press("tone", 5.0, 0.1, target_n=1.0, tolerance=0.2, hold_s=0.1, timeout_s=5.0, interval=1)
SLIDE = Slide("tone", 5.0, 0.1, target_n=1.0, tolerance=0.2, hold_s=0.1, timeout_s=5.0, speed_m_per_s=0.05)
ENGLISH = texts_in("en", {}).messages


class Leaving(Passing):
    """A screen whose participant leaves each page that has buttons."""

    def __init__(self, watched, hands, in_background):
        super().__init__(watched)
        self._hands, self._in_background = hands, in_background

    def present(self, page):
        shown_s = self.wrapped.present(page)
        if page.buttons:
            self._in_background(self._leave)
        return shown_s

    def _leave(self):
        self._hands.tap("space")


@pytest.fixture
def bench_with(bench_of, watched, hands, in_background):
    kept, screen = Kept(), Leaving(watched, hands, in_background)
    return lambda force_n=None: (bench_of(force_n, screen=screen, kept=kept, tone=BLIP, dry_run=True), kept)


def words_on(page):
    return [item.words for item in page.items if isinstance(item, Text)]


def shown(watched, name):
    words = ENGLISH[name].strip().partition("\n\n")[0]
    return sum(words in words_on(page) for page in watched.pages)


def of_dry_runs(kept):
    return [event.facts["text"] for event in kept.events if event.kind == "dry_run"]


def test_dry_run_runs_once_without_stimulus(bench_with, watched, log):
    bench, kept = bench_with(lambda time_s: 1.0)
    assert bench.answer(PRESS).valid
    assert log == ["output.open", "output.stop", "play 5 V", "output.stop"]
    assert words_on(watched.pages[0])[0] == ENGLISH["how_press"]
    assert ENGLISH["meaning_bar"] in words_on(watched.pages[0])
    assert [shown(watched, name) for name in ("dry_run", "dry_run_held", "dry_run_lost")] == [1, 1, 0]
    assert of_dry_runs(kept) == ["press: held"]
    n_pages = len(watched.pages)
    assert bench.answer(PRESS).valid
    assert len(watched.pages) == n_pages + 2, "the next touch comes at once"


def test_failed_dry_run_repeats_with_reason(bench_with, watched, log):
    bench, kept = bench_with(lambda time_s: 0.1)
    assert not bench.answer(replace(PRESS, timeout_s=0.3)).valid
    assert "play 5 V" not in log
    assert [shown(watched, name) for name in ("dry_run", "lost_timeout")] == [1, N_DRY_RUNS - 1]
    assert [shown(watched, name) for name in ("dry_run_held", "dry_run_lost")] == [0, 1]
    assert of_dry_runs(kept) == ["press: not held, the touch was not held in time"]


def test_each_touch_kind_has_a_dry_run(bench_with, watched):
    """The picture explains no bar or ring when there are no sensors."""
    bench, kept = bench_with()
    for request in (PRESS, SLIDE, PRESS, SLIDE):
        assert bench.answer(request).valid
    assert of_dry_runs(kept) == ["press: held", "slide: held"]
    pictures = [words_on(page) for page in watched.pages if ENGLISH["meaning_circle"] in words_on(page)]
    assert [picture[0] for picture in pictures] == [ENGLISH["how_press"], ENGLISH["how_slide"]]
    meanings = [[name for name in ("bar", "dot", "ring") if ENGLISH[f"meaning_{name}"] in each] for each in pictures]
    assert meanings == [[], ["dot"]]
