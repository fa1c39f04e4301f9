"""Information for the experimenter during a session."""

import json
import os
import re
import time
from dataclasses import replace

import pytest
from command_line import output
from followed_rule import with_row
from places import RECORDED
from set_clock import Clock
from tutorial_session import live

from tactometry.analysis.tasks.kinds import CURVES
from tactometry.analysis.wording import interval_text
from tactometry.experiments.sessions.recording import Who
from tactometry.experiments.watch import view
from tactometry.experiments.watch.curve import answers_of, curve_plot
from tactometry.experiments.watch.page import sections
from tactometry.experiments.watch.scenery import Scenery
from tactometry.experiments.watch.watcher import LOOK_AROUND_S, TRY_AGAIN_S, Drawn, Sight, Watcher
from tactometry.records.journal import read
from tactometry.records.open_journal import held
from tactometry.session.answer import Marked
from tactometry.session.progress import PartAhead, Progress
from tactometry.trials.trial import REASONS, Trial

DATA_SETS = sorted(path.parent for path in RECORDED.glob("*/journals"))


@pytest.mark.parametrize("root", DATA_SETS, ids=lambda root: root.name)
def test_page_draws_every_recorded_data_set(root):
    sight = Watcher(root).look()
    answers = answers_of(sight.progress)
    drawn = Drawn() if answers is None else Drawn(curve_plot(answers))
    assert sight.name
    assert sight.parts
    assert all(sections(sight, drawn)[name] for name in ("title", "where", "levels", "conditions"))


def test_watcher_returns_same_sight_without_news(journal):
    journal.holds(20)
    watcher = Watcher(journal.root)
    sight = watcher.look()
    assert watcher.look() is sight
    journal.holds(21)
    assert watcher.look() is not sight


def test_watcher_waits_for_first_session(tmp_path, journal):
    clock = Clock()
    watcher = Watcher(journal.root, clock=clock)
    assert watcher.look().state == "no session yet"
    journal.holds(20)
    clock.now_s = LOOK_AROUND_S
    assert watcher.look().state == "running"
    assert Watcher(tmp_path / "nowhere").look().state == "no session yet"


def test_watch_follows_a_new_session(tmp_path):
    clock = Clock()
    live(tmp_path)
    watcher = Watcher(tmp_path, clock=clock)
    assert view.title(watcher.look()).startswith("P01, session 1")
    live(tmp_path, Who("P02", seed=1))
    clock.now_s = LOOK_AROUND_S
    assert view.title(watcher.look()).startswith("P02, session 1")
    assert view.title(Watcher(tmp_path, "P01", 1).look()).startswith("P01, session 1")
    assert not Watcher(tmp_path, "P03").look().name


def test_damaged_journal_is_reported_and_the_view_kept(journal):
    clock = Clock()
    journal.holds(20)
    watcher = Watcher(journal.root, clock=clock)
    n_trials = watcher.look().progress.tally.n_trials
    journal.holds(20, b'{"event":"remark"}\n')
    sight = watcher.look()
    assert sight.state == "cannot be read"
    assert "line 21" in view.alerts(sight)[0]
    assert sight.progress.tally.n_trials == n_trials
    journal.holds()
    clock.now_s = TRY_AGAIN_S
    assert watcher.look().state == "over"
    assert not view.alerts(watcher.look())


def test_session_whose_process_is_gone_ended_without_closing(journal):
    journal.holds(20)
    clock, past_s = Clock(), time.time() - 60
    os.utime(journal.path, (past_s, past_s))
    watcher = Watcher(journal.root, clock=clock)
    with held([journal.path]):
        assert watcher.look().state == "running"
    clock.now_s = LOOK_AROUND_S
    assert watcher.look().state == "ended without closing"
    assert "continue with run --resume" in view.alerts(watcher.look())[0]
    journal.holds(21)
    assert watcher.look().state == "running"


@pytest.mark.parametrize("n_lines", [None, 20])
def test_ended_or_new_journal_is_not_abandoned(journal, n_lines):
    journal.holds(n_lines)
    if n_lines is None:
        os.utime(journal.path, (0, 0))
    assert Watcher(journal.root).look().state == ("over" if n_lines is None else "running")


def test_cut_journal_shows_the_rest(journal):
    journal.holds()
    watcher = Watcher(journal.root)
    watcher.look()
    journal.holds(20)
    sight = watcher.look()
    assert sight.progress.tally.n_trials == len(read(journal.path).trials)
    assert sight.state == "running"


def test_missing_study_hides_the_planned_parts(journal):
    journal.holds(20)
    (journal.root / "study.toml").unlink()
    sight = Watcher(journal.root).look()
    assert sight.parts == ()
    assert "Time left" not in [row.name for row in view.where(sight)]


def test_page_states_progress_in_mid_session(journal):
    journal.holds(60)
    sight = Watcher(journal.root).look()
    named = {row.name: row.value for row in view.where(sight)}
    trials = read(journal.path).trials
    n_valid = sum(trial.valid for trial in trials)
    assert named["Part"] == "1 of 2"
    assert named["Time left"].startswith("at most ")
    assert named["Last trial"].startswith(f"number {trials[-1].trial}, ")
    assert [share.words for share in view.shares(sight)] == [f"{n_valid} of at most 20", f"{n_valid} of at most 40"]


def test_page_warns_before_a_track_is_aborted(journal):
    journal.holds(20)
    sight, lost = Watcher(journal.root).look(), None
    for attempt in range(1, 6):
        row = Trial(1, 99, {}, "staircase", 1.0, "V", "yes_no", None, valid=False, attempt=attempt)
        lost = replace(sight, progress=with_row(sight.progress, row, "block 1 is aborted" if attempt == 5 else None))
        sight = lost
        if attempt == 4:
            assert view.alerts(sight) == ["Careful: the last 4 touches did not count: 1 more aborts this condition."]
    assert view.alerts(sight) == ["Block 1 is aborted."]
    assert view.condition_rows(sight.progress)[0].state == "aborted"


def test_each_reason_has_its_words():
    progress = Progress(n_touches=99, reasons=dict.fromkeys(REASONS, 1))
    assert view.reasons(progress).startswith(f"{len(REASONS)} of 99 touches not valid: ")
    assert "_" not in view.reasons(progress)


def test_abnormal_quality_is_marked():
    progress = Progress(n_frames=1000, n_dropped_frames=50, n_gaps=2, reasons={"sensor_lost": 1})
    assert [row.mark for row in view.quality(progress)] == [True, True, True]
    assert not any(row.mark for row in view.quality(Progress(n_frames=1000, n_dropped_frames=9)))


def test_user_text_is_escaped():
    sight = Sight("a", problem="<script>alert(1)</script>", progress=Progress(factors={"<b>": "<i>"}, n_parts=1))
    drawn = "".join(sections(sight, Drawn()).values())
    assert "<script>" not in drawn
    assert "<i>" not in drawn
    assert "&lt;script&gt;" in drawn


def test_questionnaire_answers_leave_levels_unchanged():
    progress = with_row(Progress(), Trial(1, 1, {"f": 1.0}, "staircase", 5.0, "dB", "yes_no", 1))
    form = Trial(2, 2, {"f": 1.0}, "sus", None, "", "rating", 1.0, item="SUS1")
    sight = Sight("a", progress=with_row(progress, form, None))
    assert {row.name: row.value for row in view.where(sight)}["Last trial"] == "sus, SUS1: 1"
    assert [mark.kind for mark in view.level_plots(sight.progress)[0].marks] == ["yes"]
    assert view.unit(sight.progress) == "dB"
    assert [row.state for row in view.condition_rows(sight.progress)] == [""]


@pytest.mark.parametrize(("name", "more"), [("frequency_hz=60", ""), ("frequency_hz=60, A - B", ", A - B"), (None, "")])
def test_track_name_adds_to_its_condition(name, more):
    row = Trial(1, 1, {"frequency_hz": 60.0}, "staircase", 5.0, "dB", "yes_no", 1, track=name)
    assert view.level_plots(with_row(Progress(), row))[0].title == f"staircase, 60 Hz{more}"


def test_levels_of_several_units_each_have_theirs():
    progress = with_row(Progress(), Trial(1, 1, {}, "staircase", 5.0, "dB", "yes_no", 1))
    assert [row.level for row in view.condition_rows(progress)] == ["5"]
    progress = with_row(progress, Trial(2, 2, {}, "staircase", 7.0, "V", "yes_no", 1))
    assert view.unit(progress) == ""
    assert [row.level for row in view.condition_rows(progress)] == ["7 V", "5 dB"]


def test_questionnaire_marks_leave_progress_unchanged(journal):
    journal.holds(20)
    sight = Watcher(journal.root).look()
    assert sight.after([Marked("sus", (1.0, None), 3.0)]).progress == sight.progress


def test_left_out_parts_have_no_share():
    assert view.shares(Sight("a", parts=(PartAhead(lasts_s=30.0),))) == []


STUDIES = {
    "yes_no": "time-reversal-threshold",
    "forced_choice": "two-interval-forced-choice",
    "comparison": "texture-discrimination",
}


@pytest.mark.parametrize("task", CURVES)
def test_live_page_reports_threshold_of_analyse(tmp_path, capsys, task):
    data = tmp_path / "data"
    output(capsys, "simulate", STUDIES[task], "--participants", "1", "--seed", "3", "--out", data)
    found = json.loads(output(capsys, "analyse", data, "--json"))["thresholds"]
    rows = [row for row in found if row["status"] == "ok"]
    texts = [interval_text(row["threshold"], row["interval_low"], row["interval_high"]) for row in rows]
    page = Scenery(Watcher(data)).sections()
    words = re.sub("<[^>]*>", "", page["curve"])
    assert any(text in words for text in texts), (texts, words)


@pytest.mark.parametrize(
    ("task", "answer"), [("comparison", "more"), ("same_different", "different"), ("yes_no", "yes")]
)
def test_last_answer_has_word_of_task(task, answer):
    trial = Trial(1, 1, {}, "constant_stimuli", 43.0, "dB", task, 1, correct=False)
    shown = with_row(Progress(), trial)
    assert {row.name: row.value for row in view.where(Sight("a", progress=shown))}["Last trial"].endswith(f": {answer}")
    assert [mark.kind for mark in view.level_plots(shown)[0].marks] == ["yes"]
