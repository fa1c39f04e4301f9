"""Resuming a session that was killed during a questionnaire."""

import time
from contextlib import contextmanager

from patience import LONGEST_WAIT_S
from study_texts import TUTORIAL, changed
from tables import is_sound, trial_rows
from window_sitting import tactometry

RATED = {
    'duration_s = "500 ms"': 'duration_s = "100 ms"',
    'hold_s = "300 ms"': 'hold_s = "20 ms"',
    'kind = "yes_no"\ncatch_rate = 0.2': 'kind = "rating"\nform = "attrakdiff-mini"',
    "frequency_hz = [60, 240]": "frequency_hz = [60]",
    "levels = [22, 28, 34, 40] ": "levels = [40] ",
    "repeats = 4": "repeats = 1",
}


def until(holds, act=lambda: None):
    """Repeat an action until a condition is true."""
    deadline_s = time.perf_counter() + LONGEST_WAIT_S
    while not holds():
        assert time.perf_counter() < deadline_s
        act()
        time.sleep(0.05)


@contextmanager
def sitting(*arguments):
    """Run a session in a process that is killed when the context ends."""
    process = tactometry(*arguments)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def test_killed_form_resumes_on_its_page_with_marks(display, tmp_path):
    (tmp_path / "s.toml").write_text(changed(TUTORIAL, RATED), "utf-8")
    run = ("run", tmp_path / "s.toml", "--participant", "P01", "--rig", "bench", "--seed", "7", "--out", tmp_path / "d")

    def kept(what):
        return any(what in path.read_text("utf-8") for path in (tmp_path / "d").glob("journals/*.jsonl"))

    with sitting(*run):
        until(lambda: kept('"Slide"'), lambda: display.tap("space"))
        until(lambda: kept('"values":[2.0,2.0,2.0,2.0,2.0]'), lambda: display.tap("2"))
        until(lambda: kept('"Fill"'), lambda: display.tap("Return"))
        until(lambda: kept('"values":[7.0,null,null,null,null]'), lambda: kept("[7") or display.tap("7"))
    with sitting(*run, "--resume") as second:  # one of five items is already marked
        until(lambda: kept('"values":[7.0,3.0,3.0,3.0,3.0]'), lambda: display.tap("3"))
        until(lambda: second.poll() is not None, lambda: display.tap("Return"))
    rows = [row for row in trial_rows(tmp_path / "d") if row["item"]]
    assert [float(row["response"]) for row in rows] == [2] * 5 + [7, 3, 3, 3, 3]
    assert is_sound(tmp_path / "d")
