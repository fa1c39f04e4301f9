"""Every page in a real window, answered by real X key and mouse events."""

import time

import numpy as np
import pytest
from experimenter_seat import BLIP
from hard_cases import exact_case
from patience import LONGEST_WAIT_S

from tactometry.errors import DeviceFailed, InvalidParameter, LimitExceeded, Stopped
from tactometry.rigs.pages.page import KeyDown, Page, Text
from tactometry.session.request import Adjust, Choose, Play, Press, Record, Show, Slide, Wait
from tactometry.trials.trial import Trial

FELT = Choose("felt", (0, 1), ("no", "yes"))
WHICH = Choose("which_interval", (1, 2), ("1", "2"))
TRIAL = Trial(1, 1, {}, "staircase", 1.0, "V", "yes_no", 1)


@pytest.mark.parametrize("leave", ["space", "Return", "KP_Enter", (0.4, -0.3)], ids=str)
def test_message_closes_on_key_or_touch(bench, participant, leave):
    participant.answers("y", leave)
    assert bench.answer(Show("block", {"part": 1, "n_parts": 3})).at_s > 0


def test_rest_page_counts_down(bench, watched, log):
    begin_s = time.perf_counter()
    bench.answer(Show("resting", duration_s=1.3))
    assert time.perf_counter() - begin_s >= 1.3
    said = [next(item.words for item in page.items if "s." in getattr(item, "words", "")) for page in watched.pages]
    assert [words.rsplit("in ", 1)[1] for words in said] == ["2 s.", "1 s."]


@pytest.mark.parametrize(
    ("question", "act", "option"),
    [
        (FELT, "y", 1),
        (FELT, "n", 0),
        (FELT, "1", 1),
        (FELT, "KP_0", 0),
        (FELT, (-0.23, -0.06), 0),
        (FELT, (0.23, -0.06), 1),
        (WHICH, "1", 1),
        (WHICH, "KP_2", 2),
        (WHICH, (0.23, -0.06), 2),
    ],
)
def test_question_accepts_letter_digit_or_touch(bench, participant, question, act, option):
    participant.answers(act)
    chosen = bench.answer(question)
    assert (chosen.option, chosen.valid) == (option, True)
    assert chosen.latency_s > 0
    assert chosen.timestamp_utc.endswith("+00:00")


def test_touch_outside_boxes_is_ignored(bench, participant):
    participant.answers((0.0, 0.4), "q", "n")
    assert bench.answer(FELT).option == 0


def test_latency_is_measured_to_key_press(bench, watched, hands, in_background):
    press, onset = {}, []

    def work():
        watched.shown.get(timeout=LONGEST_WAIT_S)
        time.sleep(0.1)
        press["down_s"], press["up_s"] = hands.tap("y", hold_s=0.3)

    present, watched.present = watched.present, lambda page: onset.append(present(page)) or onset[-1]
    in_background(work)
    chosen = bench.answer(FELT)
    time.sleep(0.4)
    down_s = onset[0] + chosen.latency_s
    assert press["down_s"] - 0.002 <= down_s <= press["up_s"]
    assert chosen.latency_s >= 0.1


def test_shortest_taps_are_recorded(bench, participant):
    participant.answers_each_page("y", "n", "n", "y", "y", "n", hold_s=0.0)
    assert [bench.answer(FELT).option for _ in range(6)] == [1, 0, 0, 1, 1, 0]
    exact_case("taps of no duration in the window", against="every answer")


def test_key_pressed_before_question_is_ignored(bench, participant, hands, in_background):
    """PsychoPy returns an earlier press again when its key is released."""
    in_background(hands.tap, "y", 0.6)
    time.sleep(0.2)
    participant.answers(0.8, "n")
    assert bench.answer(FELT).option == 0


def test_adjustment_stays_within_bounds(bench, participant, log):
    participant.answers(*["Up", 0.1] * 3, "Down", 0.1, "Return")
    adjusted = bench.answer(Adjust("tone", start=10.0, step=5.0, low=0.0, high=20.0))
    assert adjusted.level == 15.0
    levels = [entry for entry in log if entry.startswith("play")]
    assert list(dict.fromkeys(levels)) == ["play 10 V", "play 15 V", "play 20 V"]
    assert levels[-1] == "play 15 V"
    assert log[-1] == "output.stop"


def test_stimulus_plays_in_its_interval(bench, log):
    played = bench.answer(Play("tone", 5.0, duration_s=0.2, interval=2))
    after = bench.answer(Wait(0.05))
    assert (played.level_delivered, played.digest) == (5.0, BLIP.at(5.0).digest())
    assert after.at_s - played.onset_s >= 0.25
    assert log == ["output.open", "play 5 V"]


def test_blank_interval_lasts_equally_long_without_playback(bench, log):
    before_s = bench.answer(Record(TRIAL)).at_s
    played = bench.answer(Play("tone", None, duration_s=0.2))
    assert (played.level_delivered, played.digest) == (None, "")
    assert bench.answer(Record(TRIAL)).at_s - before_s >= 0.2
    assert log == ["output.open"]


@pytest.mark.parametrize(
    "request_",
    [
        Press("tone", 5.0, 0.1, 1.0, 0.2, hold_s=0.1, timeout_s=5.0, interval=1),
        Slide("tone", 5.0, 0.1, 1.0, 0.2, hold_s=0.1, timeout_s=5.0, speed_m_per_s=0.05),
    ],
)
def test_touch_is_valid_without_sensor(bench, log, request_):
    touched = bench.answer(request_)
    assert (touched.valid, touched.digest, touched.level_delivered) == (True, BLIP.at(5.0).digest(), 5.0)
    assert touched.force_mean_n is touched.force_sd_n is touched.force_in_band is touched.speed_mean_m_per_s is None
    assert touched.onset_s >= 0.1
    assert log == ["output.open", "play 5 V"]


PRESS = Press("tone", 5.0, 30.0, 1.0, 0.2, hold_s=0.05, timeout_s=5.0)
REQUESTS = [Show("end"), FELT, Wait(30.0), Play("tone", 5.0, 30.0), PRESS, Adjust("tone", 5, 1, 0, 9)]


@pytest.mark.parametrize("request_", REQUESTS, ids=lambda request: type(request).__name__)
def test_escape_stops_output_before_closing(bench, participant, log, request_):
    participant.answers("Escape")
    with pytest.raises(Stopped, match="Escape was pressed; recorded data are safe"):
        bench.answer(request_)
    assert log[-3:] == ["output.stop", "output.close", "screen.close"]
    with pytest.raises(DeviceFailed, match="bench: found a closed bench"):
        bench.answer(request_)


def test_stopped_page_stays_until_next_key(bench, watched, participant, log, monkeypatch):
    """The output is stopped while the page is shown."""
    monkeypatch.setattr("tactometry.rigs.experimenter.supervisor.STOPPED_S", 3600.0)
    participant.answers("Escape", 0.3, "q")
    with pytest.raises(Stopped):
        bench.answer(Play("tone", 5.0, 30.0))
    words = [item.words for item in watched.pages[-1].items if isinstance(item, Text)]
    assert words[:2] == ["Stopped", "Lift your finger. Your answers are kept.\nPlease call the experimenter."]
    assert log[-3:] == ["output.stop", "output.close", "screen.close"]


@pytest.mark.parametrize(
    ("request_", "error", "message"),
    [
        (Play("tone", 51.0, 0.2), LimitExceeded, r"found a peak of 51 V, the limit is 50 V; .*nothing was played"),
        (Play("tome", 5.0, 0.2), InvalidParameter, "found 'tome', expected one of tone; did you mean 'tone'"),
        (Play("tone", 5.0, 0.05), InvalidParameter, "a signal of 0.1 s, expected at most the 0.05 s"),
        (Show("block", {}), InvalidParameter, "message 'block': found a placeholder that cannot be filled"),
        (Show("welcom"), InvalidParameter, "message 'welcom': found no text .*did you mean 'welcome'"),
    ],
)
def test_bad_requests_play_nothing_and_close(bench, log, request_, error, message):
    with pytest.raises(error, match=message):
        bench.answer(request_)
    assert list(dict.fromkeys(log)) == ["output.open", "output.stop", "output.close", "screen.close"]


@pytest.mark.parametrize(
    ("failure", "error"),
    [
        (SystemExit(0), pytest.raises(DeviceFailed, match=r"ended the program \(exit status 0\)")),
        (KeyboardInterrupt(), pytest.raises(KeyboardInterrupt)),
        (OSError("unplugged"), pytest.raises(OSError, match="unplugged")),
    ],
    ids=["SystemExit", "Ctrl-C", "OSError"],
)
def test_failure_during_playback_zeroes_output_first(bench, watched, log, failure, error):
    def fail(page):
        raise failure

    watched.refresh = fail
    with error:
        bench.answer(Play("tone", 5.0, 0.2))
    assert log == ["output.open", "play 5 V", "output.stop", "output.close", "screen.close"]
    exact_case("any failure while a stimulus plays", against="the output is zeroed first")


def test_close_continues_when_output_fails_to_stop(bench, output, log):
    def fail():
        raise OSError("unplugged")

    output.stop = fail
    with pytest.raises(OSError, match="unplugged"):
        bench.close()
    assert log[-2:] == ["output.close", "screen.close"]


def test_resumed_session_continues_its_clock(bench):
    bench.resume([TRIAL], elapsed_s=100.0)
    assert 100.0 < bench.answer(Record(TRIAL)).at_s < 160.0


def test_facts_include_display_keyboard_and_clock(bench):
    facts = bench.facts()
    assert (facts["rig"], facts["keyboard"], facts["clock"]) == ("bench", "ptb", "time.perf_counter")
    assert (facts["display_width_px"], facts["display_height_px"]) == (1280, 800)
    assert (facts["output"], facts["force_sensor"]) == ("list", None)
    assert facts["frames_paced_in_software"] is True
    assert facts["frame_period_s"] == pytest.approx(1 / 60, abs=1e-6)


def test_frames_are_counted_and_paced(bench, screen):
    screen.frame_intervals_s()
    bench.answer(Wait(0.5))
    intervals_s = screen.frame_intervals_s()
    assert 2 <= len(intervals_s) <= 31
    assert np.median(intervals_s) > 0.01
    assert screen.frame_intervals_s() == []


def test_window_events_are_returned_once(screen, hands):
    screen.present(Page())
    hands.tap("q", hold_s=0.1)
    seen = []
    for _ in range(20):
        seen += [event.name for event in screen.events() if isinstance(event, KeyDown)]
        screen.refresh(Page())
    assert seen == ["q"]
