"""Resuming sessions killed during demographics, consent or rests."""

import os
import time
from collections import Counter
from itertools import cycle

import numpy as np
import pytest
from patience import LONGEST_WAIT_S
from scripted_finger import Eye
from short_studies import shortened
from study_texts import changed
from tables import is_sound, trial_rows
from window_sitting import tactometry

from tactometry.records.journal import read
from tactometry.rigs.pages.page import PAPER
from tactometry.session.request import ABOUT, CONSENT, Choose, Record, Show

pytestmark = pytest.mark.slow  # ten starts of a window
RESTING = {
    'kind = "yes_no"\ncatch_rate = 0.2': 'kind = "yes_no"\nrest_every_s = "100 ms"\nrest_s = "4 s"',
    "levels = [22, 40]": "levels = [40]",
    "repeats = 1": "repeats = 3",  # a rest is due after the second trial, but not after the last
    'duration_s = "500 ms"': 'duration_s = "100 ms"',
}
PERSON = '[inquiries.person]\nform = "demographics"\nafter = "start"\n'
BENCH = "[screen]\nfullscreen = false\ndry_run = false\n"


class Killed:
    """A session that can be killed and resumed."""

    def __init__(self, folder, study, hands, eye):
        self._hands, self._eye, self._process = hands, eye, None
        self.data = folder / "data"
        (folder / "s.toml").write_text(study, "utf-8")
        (folder / "bench.toml").write_text(BENCH, "utf-8")
        bench = ("--bench", folder / "bench.toml")
        self._command = ("run", folder / "s.toml", "--participant", "P01", "--seed", "7", *bench, "--out", self.data)
        self.page = np.zeros(0)
        """The current page, or the page at the time of the kill."""

    def begin(self):
        """Start the session, or resume it on the page it was killed on."""
        self._run()
        before, self.page = self.page, self.new_page()
        assert not before.size or np.array_equal(before, self.page)

    def begin_anywhere(self):
        """Resume where the page may have changed by itself."""
        self._run()
        self.page = self.new_page()

    def _run(self):
        self._eye.cover()
        resumed = ["--resume"] if self.data.exists() else []
        self._process = tactometry(*self._command, *resumed)

    def kill(self):
        self._process.kill()
        self._process.communicate()

    def answer(self, key):
        """Press a key; wait until its answer is saved and the next page appears."""
        n_before = len(self.requests())
        self._hands.tap(key)
        self.until(lambda: len(self.requests()) > n_before)
        self.page = self.new_page(unlike=self.page)

    def answer_until(self, holds, answer="y"):
        """Leave text pages and answer questions until a condition is true."""
        keys = cycle(("space", answer))
        self.until(holds, lambda: self._hands.tap(next(keys)))

    def ended(self):
        """Answer until the session ends; return its exit status and error output."""
        self.answer_until(lambda: self._process.poll() is not None)
        return self._process.returncode, self._process.communicate()[1]

    def requests(self):
        """Return the answered requests in the journal."""
        files = [path for path in self.data.glob("journals/*.jsonl") if "interruptions" not in path.name]
        return [request for request, _ in read(files[0]).entries] if files else []

    def until(self, holds, act=lambda: None):
        deadline_s = time.perf_counter() + LONGEST_WAIT_S
        while not holds():
            assert time.perf_counter() < deadline_s
            assert self._process.poll() is None or holds(), self._process.communicate()
            act()
            time.sleep(0.1)

    def new_page(self, unlike=None):
        """Wait for the next picture that is steady and not blank."""
        paper, seen = np.array(tuple(bytes.fromhex(PAPER[1:]))), []

        def stands():
            seen.append(self._eye.picture())
            steady = len(seen) > 1 and np.array_equal(seen[-1], seen.pop(0))
            says = seen[-1].any() and (seen[-1] != paper).any()
            return steady and says and (unlike is None or not np.array_equal(seen[-1], unlike))

        self.until(stands)
        return seen[-1]


@pytest.fixture
def session(display, tmp_path):
    eye, made = Eye(os.environ["DISPLAY"]), []

    def make(study):
        made.append(Killed(tmp_path, study, display, eye))
        return made[-1]

    yield make
    for each in made:
        each.kill()
    eye.close()


def messages(killed):
    return [request.message for request in killed.requests() if isinstance(request, Show)]


def n_trials(killed):
    return sum(isinstance(each, Record) and not each.trial.item for each in killed.requests())


def on_each_page(killed, *keys):
    """For each key, resume, answer one page, and kill on the next page."""
    for key in keys:
        killed.begin()
        killed.answer(key)
        killed.kill()


def test_demographics_and_timed_rests_are_shown_once(session):
    killed = session(f"{changed(shortened('tutorial'), RESTING)}\n{PERSON}")
    on_each_page(killed, "space", "space", "3", "2", "1")  # welcome, the page before the questions, the questions
    killed.begin()
    killed.answer_until(lambda: n_trials(killed) == 2)
    killed.kill()
    assert "resting" not in messages(killed)  # the rest page was interrupted
    killed.begin_anywhere()
    killed.until(lambda: "resting" in messages(killed))
    killed.page = killed.new_page()
    killed.kill()
    killed.begin()
    assert killed.ended() == (0, "")
    rows = trial_rows(killed.data)
    answers = [(row["item"], row["response"]) for row in rows if row["item"]]
    assert answers == [("age_band", "3"), ("handedness", "2"), ("gender", "1")]
    assert [row["response"] for row in rows if not row["item"]] == ["1"] * 3
    asked = Counter(request.question for request in killed.requests() if isinstance(request, Choose))
    assert {name: n for name, n in asked.items() if name.startswith(ABOUT)} == {
        f"{ABOUT}demographics.{item}": 1 for item in ("age_band", "handedness", "gender")
    }
    assert max(Counter(messages(killed)).values()) == 1
    assert is_sound(killed.data)


def test_declined_consent_is_not_asked_again(session):
    """The session is killed on the closing page, which is shown again."""
    killed = session(f"consent = true\n{shortened('tutorial')}")
    killed.begin()
    for key in ("space", "space", "0"):
        killed.answer(key)
    killed.kill()
    killed.begin()
    assert killed.ended() == (1, "")  # no block was completed
    told = [request.question if isinstance(request, Choose) else request.message for request in killed.requests()]
    assert told == ["welcome", "consent", CONSENT, "declined"]
    assert is_sound(killed.data)


PRACTICE = '[practice]\nlevels = [40.0]\nn_correct = 1\nn_of = 1\nn_trials = 1\non_miss = "ask"\n'


def test_missed_practice_is_decided_once_when_killed(session):
    """Kill the session on the page of the choice, then on the page after it."""
    killed = session(f"{changed(shortened('tutorial'), {'catch_rate = 0.2': 'catch_rate = 0.0'})}\n{PRACTICE}")
    killed.begin()
    killed.answer_until(lambda: n_trials(killed) == 1, "n")
    killed.page = killed.new_page()
    killed.until(lambda: "wrong" in messages(killed))
    killed.page = killed.new_page(unlike=killed.page)
    killed.kill()
    killed.begin()
    killed.answer("g")
    killed.kill()
    killed.begin()
    assert killed.ended() == (0, "")
    chosen = [request for request in killed.requests() if isinstance(request, Choose)]
    assert [request.question for request in chosen][:3] == ["felt", "practice_missed", "felt"]
    assert [row["practice"] for row in trial_rows(killed.data)].count("1") == 1
    assert is_sound(killed.data)
