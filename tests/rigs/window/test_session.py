"""A session in a real window: stopped, resumed, validated, replayed."""

import json
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from emulated import wait_for
from hard_cases import exact_case
from study_texts import tutorial_in
from tables import is_sound, trial_rows
from window_sitting import sit, tactometry

SHORT = {
    'duration_s = "500 ms"': 'duration_s = "100 ms"',
    'hold_s = "300 ms"': 'hold_s = "20 ms"',
    "repeats = 4": "repeats = 1",
}
OF_BOXES_PX = (288, 448), (656, 448)
"""Points on the borders of both answer boxes."""


def keys(hands, seed):
    """Yield answers 0.3 s after a question is drawn: answers in its first frame have no latency."""

    def asks():
        return all(min(hands.sees_at(*point)) > 200 for point in OF_BOXES_PX)

    for answer in np.random.default_rng(seed).choice(["y", "n"], 500):
        while not asks():
            yield "space"
        time.sleep(0.3)
        yield str(answer)
        wait_for(lambda: not asks())


def until_trials(hands, journals, n_trials):
    """Yield keys until the journal has a number of trials, then Escape."""
    for key in keys(hands, 1):
        if sum(path.read_text().count('"Record"') for path in journals.glob("*.jsonl")) >= n_trials:
            break
        yield key
    yield from ["Escape"] * 20


@dataclass(frozen=True)
class Sitting:
    data: Path
    escaped: tuple[int, str, str]
    resumed: tuple[int, str, str]

    @property
    def rows(self):
        return trial_rows(self.data)


@pytest.fixture(scope="module")
def sitting(display, tmp_path_factory):
    folder = tmp_path_factory.mktemp("session")
    data = folder / "pilot"
    run = ("run", tutorial_in(folder, SHORT), "--participant", "P01", "--rig", "bench", "--seed", "7", "--out", data)
    escaped = sit(tactometry(*run), display, until_trials(display, data / "journals", 3))
    resumed = sit(tactometry(*run, "--resume"), display, keys(display, 2))
    return Sitting(data, escaped, resumed)


def test_escape_ends_session_with_status_1(sitting):
    status, _, errors = sitting.escaped
    assert status == 1
    assert "Escape was pressed; recorded data are safe" in errors
    assert "Traceback" not in errors


def test_resumed_session_completes(sitting):
    status, output, errors = sitting.resumed
    assert (status, errors) == (0, "")
    assert f"{len(sitting.rows)} trials" in output


def test_resumed_session_records_every_trial_once(sitting):
    levels = [(row["frequency_hz"], row["level"]) for row in sitting.rows if row["level"]]
    assert sorted(levels) == sorted([(f, v) for f in ("60", "240") for v in ("22", "28", "34", "40")])
    assert [row["trial"] for row in sitting.rows] == [str(n + 1) for n in range(len(sitting.rows))]
    exact_case("a session in the window, stopped and resumed", against="every trial once")


def test_answers_have_latencies_and_increasing_onsets(sitting):
    onsets_s = [float(row["onset_s"]) for row in sitting.rows]
    assert onsets_s == sorted(onsets_s)
    assert all(float(row["latency_s"]) > 0 for row in sitting.rows)
    assert {row["response"] for row in sitting.rows} == {"0", "1"}
    assert {row["force_mean_n"] for row in sitting.rows} == {""}


def test_journal_records_display_keyboard_and_clock(sitting):
    [path] = (sitting.data / "journals").glob("*.jsonl")
    head = json.dumps(json.loads(path.read_text().splitlines()[0]))
    assert all(fact in head for fact in ('"ptb"', '"time.perf_counter"', '"display_width_px"', '"psychopy"'))


def test_data_set_validates_and_replays(sitting):
    assert is_sound(sitting.data)
