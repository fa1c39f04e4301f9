"""Orders and output of the experimenter's terminal during a window session."""

import threading
import time
from dataclasses import replace

import pytest
from emulated import wait_for
from experimenter_seat import FELT, PRESS, ROW, waits_until
from patience import LONGEST_WAIT_S

from tactometry.errors import InvalidParameter, Stopped
from tactometry.rigs.experimenter.terminal import ExperimenterTerminal, order_of
from tactometry.session.answer import Intervention
from tactometry.session.event import intervention_of
from tactometry.session.request import Adjust, Enter, Fill, Intervene, Play, Press, Question, Record, Show, Wait


def test_remark_is_recorded_with_time_during_a_page(bench_with, terminal, kept):
    terminal.types("n the participant coughed, twice")
    bench = bench_with()
    waits_until(bench, lambda: terminal.sees("noted"))
    assert kept.told == [("remark", "the participant coughed, twice")]
    assert 0 <= kept.events[0].at_s < LONGEST_WAIT_S
    assert kept.events[0].timestamp_utc.endswith("+00:00")


def test_pause_holds_session_and_repeats_question(bench_with, terminal, kept, watched, hands, in_background):
    def act():
        watched.shown.get(timeout=LONGEST_WAIT_S)
        terminal.types("p")
        watched.shown.get(timeout=LONGEST_WAIT_S)
        hands.tap("y")
        time.sleep(0.2)
        terminal.types("g")
        again_s.append(watched.shown.get(timeout=LONGEST_WAIT_S))
        hands.tap("n")

    again_s, bench = [], bench_with()
    in_background(act)
    chosen = bench.answer(FELT)
    assert (chosen.option, chosen.valid) == (0, True)
    assert chosen.onset_s == pytest.approx(again_s[0] - bench._supervisor.zero_s, abs=1e-5)
    assert kept.told == [("pause", "the experimenter"), ("resume", "the experimenter")]
    assert kept.events[1].at_s - kept.events[0].at_s >= 0.2


def test_pause_during_stimulus_makes_touch_invalid(bench_with, terminal, kept, log, in_background):
    def act():
        wait_for(lambda: "play 5 V" in log)
        terminal.types("p")
        wait_for(lambda: ("pause", "the experimenter") in kept.told)
        n_played.append(log.count("play 5 V"))
        time.sleep(0.4)
        n_played.append(log.count("play 5 V"))
        terminal.types("g")

    n_played, bench = [], bench_with(lambda time_s: 1.0)
    in_background(act)
    touched = bench.answer(Press("tone", 5.0, 600.0, 1.0, 0.2, hold_s=0.1, timeout_s=20.0))
    assert (touched.valid, touched.invalid_reason) == (False, "experimenter")
    assert n_played == [1, 1]
    assert log[log.index("play 5 V") + 1] == "output.stop"


def test_no_stimulus_plays_during_pause(bench_with, terminal, kept, log, in_background):
    def act():
        wait_for(lambda: ("pause", "the experimenter") in kept.told)
        time.sleep(2.5)
        n_played.append(log.count("play 5 V"))
        terminal.types("g")

    n_played = []
    terminal.types("pause")
    bench = bench_with(lambda time_s: 1.0)
    in_background(act)
    assert bench.answer(Press("tone", 5.0, 0.3, 1.0, 0.2, hold_s=2.0, timeout_s=20.0)).valid
    assert n_played == [0]


def test_ungated_stimulus_replays_after_pause(bench_with, terminal, kept, log, in_background):
    def act():
        wait_for(lambda: "play 5 V" in log)
        terminal.types("p\ng")

    bench = bench_with()
    in_background(act)
    bench.answer(Play("tone", 5.0, 0.5))
    assert log.count("play 5 V") == 1 + kept.told.count(("resume", "the experimenter"))


def test_repeat_order_invalidates_current_trial_only(bench_with, terminal, kept, participant, watched):
    bench = bench_with()
    terminal.types("r")
    touched = bench.answer(PRESS)
    watched.shown.queue.clear()
    participant.answers("y")
    chosen = bench.answer(FELT)
    bench.answer(ROW)
    again = bench.answer(PRESS)
    assert (touched.valid, chosen.valid, again.valid) == (False, False, True)
    assert (touched.invalid_reason, again.invalid_reason) == ("experimenter", None)
    assert kept.told[0] == ("repeat", "the experimenter")
    terminal.shows("this trial will be repeated")
    terminal.shows("trial 2: tone 5")


def test_orders_are_returned_with_next_record(bench_with, terminal, kept):
    bench = bench_with()
    assert bench.answer(ROW).interventions == ()
    terminal.types("i")
    terminal.types("k\nb\nend\ne")
    waits_until(bench, lambda: terminal.sees("already noted; it"))
    wanted = bench.answer(Record(replace(ROW.trial, trial=8))).interventions
    assert wanted == (Intervention("invalidate", (2, 7, 1)), *map(Intervention, ("skip", "rest", "end")))
    orders = [event for event in kept.events if event.kind == "order"]
    assert tuple(map(intervention_of, orders)) == wanted
    assert bench.answer(Record(replace(ROW.trial, trial=9))).interventions == ()
    terminal.shows("trial 7: noted; it takes effect after this trial or page")


def test_orders_are_returned_with_a_page(bench_with, terminal, participant, watched):
    bench = bench_with()
    terminal.types("skip")
    waits_until(bench, lambda: terminal.sees("noted; it takes effect"))
    watched.shown.queue.clear()
    participant.answers("space")
    assert bench.answer(Show("rest")).interventions == (Intervention("skip"),)


def test_trial_can_be_invalidated_only_once(bench_with, terminal, kept):
    bench = bench_with()
    terminal.types("i")
    waits_until(bench, lambda: terminal.sees("no trial has been recorded yet, so none can be invalidated"))
    [wanted] = [bench.answer(ROW), terminal.types("i"), bench.answer(Wait(0.3)), bench.answer(ROW)][-1].interventions
    assert bench.answer(Intervene(wanted, "trial 7 does not count: it is asked again", (ROW.trial.key,))).at_s > 0
    terminal.shows("trial 7 does not count: it is asked again")
    terminal.types("i")
    waits_until(bench, lambda: terminal.sees("trial 7 is already invalid"))
    assert [event.kind for event in kept.events if event.kind == "order"] == ["order"]


def test_pending_orders_continue_after_resume(bench_with, terminal, kept):
    kept.wanted = (Intervention("invalidate", (2, 7, 1)), Intervention("rest"))
    bench = bench_with()
    bench.resume([ROW.trial], 60.0)
    assert terminal.sees("pending order from the last sitting: rest")
    assert bench.answer(Record(replace(ROW.trial, trial=8))).interventions == kept.wanted


ITEM = Question("item", {"en": ("", "low", "high")})


@pytest.mark.parametrize(
    ("ask", "keys"),
    [
        (Enter("how_strong", 0.0), ("7", "Return")),
        (Fill("form", (ITEM,), 1.0, 5.0, 5), ("3", "Return")),
        (Adjust("tone", start=5.0, step=5.0, low=0.0, high=20.0), ("Return",)),
    ],
    ids=lambda value: type(value).__name__,
)
def test_repeat_order_invalidates_every_answer_type(bench_with, terminal, participant, watched, ask, keys):
    bench = bench_with()
    bench.answer(PRESS)
    watched.shown.queue.clear()
    terminal.types("r")
    participant.answers(lambda: terminal.shows("this trial will be repeated"), *keys)
    assert not bench.answer(ask).valid
    bench.answer(ROW)
    watched.shown.queue.clear()
    participant.answers(0.3, *keys)
    assert bench.answer(ask).valid


def test_repeat_order_is_refused_between_trials(bench_with, terminal, kept):
    bench = bench_with()
    terminal.types("r")
    waits_until(bench, lambda: terminal.sees("no trial is running, so none can be repeated"))
    assert bench.answer(PRESS).valid
    assert kept.told == [("stimulus", None)]


@pytest.mark.parametrize("paused", [False, True], ids=["at once", "in a pause"])
def test_stop_order_zeroes_output_first(bench_with, terminal, kept, log, paused):
    bench = bench_with()
    terminal.types("p\nstop" if paused else "stop")
    with pytest.raises(Stopped, match="the experimenter stopped the session; recorded data are safe: continue with"):
        bench.answer(PRESS)
    assert kept.told[-1] == ("stop", "the experimenter stopped the session")
    assert log.index("output.stop") < log.index("output.close") < log.index("screen.close")


def test_closing_the_window_stops_the_session(bench_with, kept, watched, screen, in_background, log):
    def close():
        watched.shown.get(timeout=LONGEST_WAIT_S)
        screen._window.winHandle.dispatch_event("on_close")

    bench = bench_with()
    in_background(close)
    with pytest.raises(Stopped, match="the window was closed; recorded data are safe: continue with --resume"):
        bench.answer(FELT)
    assert kept.told == [("stop", "the window was closed")]
    assert log[-3:] == ["output.stop", "output.close", "screen.close"]


def test_unknown_order_lists_valid_orders(bench_with, terminal, kept):
    for line in ("pasue", "n", "s now", "", "\x00\xff"):
        terminal.types(line)
    terminal.types("?")
    waits_until(bench_with(), lambda: terminal.sees("found 's now', expected one of: p pause"))
    terminal.shows("found 'pasue', expected one of: p pause")
    terminal.shows("did you mean 'pause'?")
    assert kept.told == []


@pytest.mark.parametrize("line", ["", "x", "pause now", "note", "n   "])
def test_order_must_match_exactly(line):
    with pytest.raises(InvalidParameter, match="expected one of: p pause"):
        order_of(line)


def test_repeated_trial_is_shown_with_reason_and_row(bench_with, terminal):
    bench = bench_with()
    bench.answer(PRESS)
    bench.answer(Record(replace(ROW.trial, response=None, valid=False, invalid_reason="too_light")))
    bench.answer(PRESS)
    bench.answer(Record(replace(ROW.trial, attempt=2)))
    terminal.shows("no answer, not valid: too light")
    terminal.shows("trial 2: tone 5")
    terminal.shows("1, valid (trial 7, attempt 2)")


def test_output_after_session_starts_on_new_line(bench_with, terminal):
    bench = bench_with()
    bench.answer(PRESS)
    bench.close()
    terminal.output.write("$")
    terminal.output.flush()
    terminal.shows("\r\n$")


def test_aborted_block_is_reported_immediately(bench_with, terminal):
    bench = bench_with()
    bench.answer(Record(replace(ROW.trial, valid=False, invalid_reason="timeout"), aborted="block 2 is aborted: so"))
    assert terminal.sees("the touch was not held in time (trial 7)\r\n! block 2 is aborted: so\r\n")


def test_multi_row_trial_is_one_event(bench_with, terminal, kept):
    def rows(level, n_trial):
        item = replace(ROW.trial, trial=n_trial, task="rating", procedure="vas", level=level, response=3.0)
        return [Record(replace(item, item=name)) for name in ("pleasant", "intense")]

    bench = bench_with()
    for row in [*rows(5.0, 7), *rows(None, 8), *rows(5.0, 9)]:
        bench.answer(Wait(0.05))
        bench.answer(row)
    bench.answer(Wait(0.0))
    trials = [event.facts for event in kept.events if event.kind == "trial"]
    assert [facts["trial"] for facts in trials] == [7, 9]
    assert trials[1]["n_frames"] <= 6  # frames of its own wait, without those of the questionnaire
    bench.answer(PRESS)
    terminal.shows("trial 3: tone 5")
    assert terminal._seen.count(b"valid (") == 2


def test_silent_sensor_pauses_session_until_it_recovers(bench_with, kept, log, terminal):
    touched = bench_with(lambda time_s: None if time_s < 1.0 else 1.0).answer(PRESS)
    assert touched.valid
    silent = "the force sensor is silent"
    *pauses, began, ended = kept.told
    # on a busy machine a delayed sensor thread may cause further pauses
    assert pauses == [("pause", silent), ("resume", silent)] * max(1, len(pauses) // 2)
    assert (began[0], ended[0]) == ("stimulus", "stimulus_end")
    terminal.shows("paused: the force sensor is silent")


def test_terminal_prints_trial_level_force_and_answer(bench_with, terminal, participant, watched):
    bench = bench_with(lambda time_s: 0.5 if time_s < 2.5 else 1.0)
    bench.answer(PRESS)
    for words in ("trial 1: tone 5", "0.50 N", "played, 1.00 N"):
        terminal.shows(words)
    watched.shown.queue.clear()
    participant.answers("y")
    bench.answer(FELT)
    bench.answer(ROW)
    terminal.shows("answered in")
    terminal.shows("1, valid")


def test_session_continues_when_terminal_disappears(bench_with, terminal, log):
    bench = bench_with(lambda time_s: 1.0)
    terminal.goes_away()
    assert bench.answer(PRESS).valid
    assert log[-1] == "output.stop"


def test_desk_is_silent_without_terminal(tmp_path, capsys):
    path = tmp_path / "orders"
    path.write_text("stop\n")
    n_threads = threading.active_count()
    with path.open() as source, (tmp_path / "told").open("w") as output:
        desk = ExperimenterTerminal(source, output)
        desk.tell("words")
        assert desk.orders() == []
    assert (tmp_path / "told").read_text() == ""
    assert threading.active_count() == n_threads
