"""Resuming sessions that were killed on each kind of page."""

import re
import signal
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count, cycle

import numpy as np
import pytest
from seen import Seen
from short_studies import shortened
from soak import SOAK
from study_texts import changed
from tables import is_sound, trial_rows
from whole_sitting import recorded_as, sitting

from tactometry.records.journal import read
from tactometry.session.request import CONSENT, Choose, Fill, Show

RESTING = {
    'kind = "yes_no"': 'kind = "yes_no"\nfeedback = true\nrest_s = 5.0',
    "rest_after = 75": "rest_after = 1",
    "n_of = 5": "n_of = 1",
    "n_trials = 20": "n_trials = 3",
    "catch_rate = 0.2": "catch_rate = 0.0",
    "repeats = 1": "repeats = 2",  # the pause after a killed feedback page ends before the finger looks
}
PRESSED = """[touch]
kind = "press"
force_n = 1.0
hold_s = "50 ms"
timeout_s = "20 s"
[task]
kind = "adjustment"
step = 2.0
low = 0.0
high = 40.0
"""


def with_rests():
    return changed(shortened("time-reversal-threshold"), RESTING)


def of_two_pages():
    study = shortened("hybrid-button")
    study = re.sub(r"\[variants\.feedback\.(time_reversal|both)[\s\S]*?(?=\n\n)", "", study)
    return changed(study, {'["time_reversal", "electrovibration", "both"]': '["electrovibration"]', **ONE})


ONE = {"levels = [36.0, 40.0]": "levels = [36.0]", "effects.feedback.both = { realism = 0.2 }": ""}


def set_by_hand():
    study = shortened("tutorial")
    study = re.sub(r"\[touch\][\s\S]*?(?=\[procedure\])", PRESSED, study)
    return changed(study, {"levels = [22, 40]": "levels = [22]"})


def with_consent():
    first = '[inquiries.person]\nform = "realism-likert"\nafter = "start"\n'
    return f"consent = true\n{shortened('tutorial')}\n{first}".replace("levels = [22, 40]", "levels = [40]")


N_BEFORE_CONSENT = 2
"""Requests before the consent question: the welcome and consent pages."""
TRIED = "tried"
"""Name of the study with a dry run, which repeats after each resume."""
STUDIES = {
    "rests": (with_rests, {"welcome", "instructions", "practice", "feedback", "block", "resting", "rest", "end"}),
    "forms": (of_two_pages, {"Slide", "questions", "Fill 1", "Fill 2"}),
    "agreed": (with_consent, {"consent", "agree", "questions_first", "instructions"}),
    "declined": (with_consent, {"welcome", "consent", "agree", "declined"}),
    "numbers": (lambda: shortened("force-loss"), {"Press", "Enter"}),
    "levels": (set_by_hand, {"Adjust"}),
    "choices": (lambda: shortened("tutorial"), {"Choose"}),
    TRIED: (lambda: shortened("tutorial"), {"Slide"}),
}
"""Study functions, each with the pages on which the session is killed."""


def one_name(message):
    return message.partition("_")[0] if message.startswith("instructions_") else message


class Turns:
    """A generator of alternating draws for correct and incorrect answers, of which the first is `first`."""

    def __init__(self, first):
        self._numbers, self._ways = count(first), cycle([0.0, 0.5])

    def integers(self, low, high=None):
        n = next(self._numbers)
        return n % low if high is None else low + n % (high - low)

    def random(self):
        return next(self._ways)


@dataclass(frozen=True)
class Killed:
    seen: Seen
    picture: np.ndarray
    n_answered: int
    is_explained: bool
    """True if the dry run repeats after each resume."""

    def tells(self, finger):
        """Return True if the current page shows where a session resumed.

        Pages that close themselves do not, such as a pause until the sensor is available.
        """
        if finger.seen.kind == "words":
            return finger.steady and finger.seen.asks
        return finger.seen.kind == "touch" or (finger.steady and finger.seen.kind != "nothing")

    def is_where(self, finger):
        """Return True if a session resumed on this page or its trial's touch."""
        seen = finger.seen
        match self.seen.kind:
            case "words":
                return not self.seen.asks or self.is_explained or np.array_equal(self.picture, finger.picture)
            case "form":
                return (seen.kind, seen.marked) == ("form", self.seen.marked)
            case "question" if self.n_answered == N_BEFORE_CONSENT:
                return np.array_equal(self.picture, finger.picture)
            case _:
                return seen.kind in ("touch", "adjust") or self.is_explained


def journal_of(data):
    [journal] = [path for path in (data / "journals").glob("*.jsonl") if "interruptions" not in path.name]
    return journal


def n_answered(data):
    return sum(line.startswith(b'{"request"') for line in journal_of(data).read_bytes().splitlines())


def page_of(requests, n):
    """Return the page name of request `n` in a sequence of requests."""
    request = requests[n]
    if isinstance(request, Show) and request.message in ("right", "wrong"):
        return "feedback"
    if isinstance(request, Show):
        return one_name(request.message)
    if isinstance(request, Choose) and request.question == CONSENT:
        return CONSENT
    if not isinstance(request, Fill):
        return type(request).__name__
    first = next(k for k in range(n, -1, -1) if not isinstance(requests[k], Fill))
    return f"Fill {n - first}"


KNOWN_BY = {"words": 1.0, "form": 0.08}
"""Share of a page, from its top, that identifies it: a whole text, or the prompt and page number of a form."""


def killed_on_each_page(seat, turns):
    """Kill a session on each new page and resume it until it completes."""
    known, killed, said = set(), [], []

    def is_new(finger):
        seen = finger.seen
        if not is_whole(finger):
            return False
        n_px = round(KNOWN_BY.get(seen.kind, 0.0) * seen.height_px)
        key = (seen.kind, seen.marker, len(seen.rows), finger.picture[:n_px].tobytes())
        new = key not in known
        known.add(key)
        return new

    while True:
        finger, goes_on = seat.finger(turns), bool(killed)
        with stopping(seat.run(*(["--resume"] if goes_on else []))) as process:
            if goes_on:
                assert finger.sit(process, killed[-1].tells), process.communicate()
                assert killed[-1].is_where(finger), (killed[-1].seen, killed[-1].n_answered, finger.seen)
            is_killed = finger.sit(process, is_new)
            said += finger.said
            if not is_killed:
                return (process.returncode, *process.communicate()), killed, said
        killed.append(Killed(finger.seen, finger.picture, n_answered(seat.data), seat.dry_run))


@contextmanager
def stopping(process):
    try:
        yield process
    finally:
        process.send_signal(signal.SIGKILL)
        process.communicate()


def is_whole(finger):
    """Return True if a steady page is visible, with a mark if it is a form.

    Pages that close themselves need not be steady.
    """
    seen = finger.seen
    passes = seen.kind == "touch" or (seen.kind == "words" and not seen.asks)
    is_page = seen.kind != "nothing" and (seen.kind != "form" or bool(set(seen.marked) - {None}))
    return is_page and (passes or finger.steady)


AT_LENGTH = ("agreed", "rests")


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in STUDIES if SOAK or name not in AT_LENGTH])
def test_killed_session_resumes_on_the_same_page(display, tmp_path, name):
    make, pages = STUDIES[name]
    study = make()
    with sitting(tmp_path, study, "en", display, dry_run=name == TRIED) as seat:
        (status, _, errors), killed, said = killed_on_each_page(seat, Turns(0 if name == "declined" else 1))
    assert (status, errors) == (int(name == "declined"), "")  # without consent no block is completed
    requests = [request for request, _ in read(journal_of(seat.data)).entries]
    assert {page_of(requests, page.n_answered) for page in killed} >= pages
    rows = [row for row in trial_rows(seat.data) if row["response"]]
    if name in ("agreed", "declined"):
        assert [request.question for request in requests if isinstance(request, Choose)].count(CONSENT) == 1
    elif name != "levels":
        assert [float(row["response"]) for row in rows] == recorded_as(said, study)
    numbers = [(row["trial"], row.get("item")) for row in rows if row["valid"] == "1"]
    assert len(numbers) == len(set(numbers))
    assert is_sound(seat.data)
