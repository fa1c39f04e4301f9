"""Duty, session time and charge count over all sittings of a session, and duty over all sessions of a participant."""

import os
import time
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from benches import file_bench
from soak import SOAK
from study_texts import tutorial_in
from tutorial_session import EXPERIMENT, TOML
from window_sitting import any_keys, sit, tactometry

from tactometry.devices.outputs.file import FileOutput, FileSettings
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import NullOutput
from tactometry.errors import LimitExceeded
from tactometry.experiments.data_sets.validation import validate
from tactometry.provenance import sha256
from tactometry.records.data_set import Session
from tactometry.records.journal import Head
from tactometry.records.open_session import OpenSession
from tactometry.safety.limits import Exposure, Limits
from tactometry.safety.load import Load
from tactometry.session.event import Event
from tactometry.signal import Signal

DUTY = 0.00026
"""Three stimuli of 0.3 s in any hour, so that a busy machine may take its time between them."""
SHORT = {
    'duration_s = "500 ms"': 'duration_s = "300 ms"',
    'hold_s = "300 ms"': 'hold_s = "20 ms"',
    "catch_rate = 0.2": "catch_rate = 0.0",
}


def test_a_session_that_goes_on_plays_no_more_than_one_that_was_not_interrupted(display, tmp_path):
    """In the window: the fourth stimulus of an hour ends the first sitting, and its like every other."""
    played = tmp_path / "played"
    bench = file_bench(tmp_path, DUTY, window_s=3600)
    words = ("run", tutorial_in(tmp_path, SHORT), "--participant", "P01", "--bench", bench)
    for sitting in range(3 if SOAK else 2):
        process = tactometry(*words, "--out", tmp_path / "d", *(["--resume"] if sitting else []), env=os.environ)
        status, _, errors = sit(process, display, any_keys(sitting))
        assert status == 3, errors
        assert (
            "limits.duty: found signals in a part of 0.000333333 of the time, the limit is 0.00026 of the time; wait"
            in errors
        )
        assert len(list(played.glob("*.npz"))) == 3
    assert validate(tmp_path / "d").defects == ()


HEAD = Head("tutorial", "0", "P01", 1, 1, 1, "bench", {})


def opened(root, session=1, code="P01", *, resume=False):
    keeper = OpenSession(root, EXPERIMENT.design(TOML), Session(code, session, "tutorial"), "bench", resume=resume)
    if not resume:
        keeper.journal.begin(replace(HEAD, participant=code, session=session, study_sha256=sha256(TOML)))
    return keeper


def stimulus(ago_s, duration_s=1.0, at_s=0.0, charge_c=0.0):
    utc = (datetime.now(UTC) - timedelta(seconds=ago_s)).isoformat(timespec="milliseconds")
    return Event("stimulus", at_s, utc, {"charge_c": charge_c}, duration_s)


def test_stimuli_of_the_last_while_are_remembered_by_the_next_sitting(tmp_path):
    keeper = opened(tmp_path)
    for ago_s in (100.0, 62.0, 50.0, 10.0):
        keeper.note(stimulus(ago_s, at_s=200.0 - ago_s, charge_c=1e-9))
    keeper.close()
    keeper = opened(tmp_path, resume=True)
    exposure = keeper.exposure(window_s=60.0)
    keeper.close()
    now_s = time.perf_counter()
    assert [(now_s - a, b - a) for a, b in exposure.intervals_s] == [
        (pytest.approx(ago_s, abs=2.0), pytest.approx(1.0)) for ago_s in (50.0, 10.0)
    ]
    assert now_s - exposure.opened_s == pytest.approx(190.0, abs=2.0)
    assert exposure.charge_c == pytest.approx(4e-9)


def test_stimuli_of_another_session_of_the_participant_count_for_duty_and_others_do_not(tmp_path):
    for session, code, ago_s in ((1, "P01", 10.0), (1, "P02", 5.0)):
        keeper = opened(tmp_path, session, code)
        keeper.note(stimulus(ago_s, at_s=7.0, charge_c=1e-9))
        keeper.close()
    keeper = opened(tmp_path, 2)
    exposure = keeper.exposure(60.0)
    keeper.close()
    [(begin_s, _)] = exposure.intervals_s
    assert time.perf_counter() - begin_s == pytest.approx(10.0, abs=2.0)
    assert (time.perf_counter() - exposure.opened_s) < 2.0
    assert exposure.charge_c == 0.0


def test_a_stimulus_that_is_yet_to_come_by_the_clock_on_the_wall_has_just_begun(tmp_path):
    keeper = opened(tmp_path)
    keeper.note(stimulus(-3600.0))
    keeper.close()
    keeper = opened(tmp_path, resume=True)
    [(begin_s, end_s)] = keeper.exposure(60.0).intervals_s
    keeper.close()
    assert begin_s <= time.perf_counter() <= end_s


# --- the guard


FINGER = Load("electrode", capacitance_f=1e-9, leak_resistance_ohm=1e6)


class Clock:
    now_s = 1000.0

    def __call__(self):
        return self.now_s


def guard(tmp_path, clock, **limits):
    stated = {"duration_s": 10.0, "current_peak_a": 1.0, "duty": 1.0, "session_s": 1e6} | limits
    return Guarded(FileOutput(FileSettings(str(tmp_path))), Limits(100.0, **stated), FINGER, clock)


def volts(duration_s, volt=10.0):
    return Signal(np.full((1, round(1e3 * duration_s)), volt), 1e3, "V")


def test_the_guard_counts_on_from_what_was_emitted_before_it_was_opened(tmp_path):
    clock = Clock()
    output = guard(tmp_path, clock, duty=0.5, duty_window_s=10.0)
    output.count_on(Exposure(1000.0, ((995.0, 1000.0),)))
    output.open()
    with pytest.raises(LimitExceeded, match=r"limits\.duty: .*; wait 5.0 s; nothing was played"):
        output.play(volts(5.0))
    clock.now_s = 1005.0
    output.play(volts(5.0))


def test_the_time_of_a_session_is_that_of_all_its_sittings(tmp_path):
    output = guard(tmp_path, Clock(), session_s=60.0)
    output.count_on(Exposure(1000.0 - 59.5))
    output.open()
    output.play(volts(0.5))
    with pytest.raises(LimitExceeded, match=r"limits\.session_s: found a session of 60\.6 s"):
        output.play(volts(1.1))


def test_net_charges_add_up_over_a_session_whatever_their_sign(tmp_path):
    """10 V on 1 Mohm for 1 s leak 10 uC; a stop takes none of it back."""
    output = guard(tmp_path, Clock(), charge_session_c=50e-6)
    output.count_on(Exposure(1000.0, (), charge_c=25e-6))
    output.open()
    output.play(volts(1.0))
    output.play(volts(1.0, -10.0))
    with pytest.raises(LimitExceeded, match=r"limits\.charge_session_c: found net charges of 5\.5e-05 C"):
        output.play(volts(1.0))


def test_what_is_emitted_is_told_and_nothing_of_a_null_output(tmp_path):
    told = []
    for output in (guard(tmp_path, Clock()), Guarded(NullOutput(), Limits(100.0))):
        output.subscribe(lambda *emission: told.append(emission))
        output.open()
        output.play(volts(0.5))
    [(_, duration_s, charge_c)] = told
    assert (duration_s, charge_c) == (0.5, pytest.approx(5e-6, rel=0.01))


def test_the_net_charge_of_an_alternating_voltage_is_none():
    samples = np.sin(2 * np.pi * 10 * np.arange(1000) / 1e3)[None]
    assert FINGER.charge_net_c(Signal(samples, 1e3, "V")) == pytest.approx(0.0, abs=1e-15)
    rising = Signal(np.array([[10.0, 10.0], [-20.0, -20.0]]), 1e3, "V")
    assert FINGER.charge_net_c(rising) == pytest.approx(20.0 * 2e-3 / 1e6)
