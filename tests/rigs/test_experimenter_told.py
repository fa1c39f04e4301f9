"""Output of the experimenter's terminal, and events in the log."""

import threading
from dataclasses import replace

from experimenter_seat import FELT, PRESS, ROW

from tactometry.rigs.experimenter.terminal import ExperimenterTerminal
from tactometry.session.request import Record, Wait


def test_terminal_prints_invalid_reason(bench_with, terminal):
    bench = bench_with()
    bench.answer(PRESS)
    bench.answer(Record(replace(ROW.trial, response=None, valid=False, invalid_reason="too_light")))
    terminal.shows("no answer, not valid: too light")


def test_repeated_trial_is_shown_with_its_row(bench_with, terminal):
    bench = bench_with()
    bench.answer(PRESS)
    bench.answer(Record(replace(ROW.trial, valid=False, invalid_reason="too_light")))
    bench.answer(PRESS)
    bench.answer(Record(replace(ROW.trial, attempt=2)))
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
    assert terminal.sees("the touch was not held as asked in time (trial 7)\r\n! block 2 is aborted: so\r\n")


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
