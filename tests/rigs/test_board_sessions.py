"""Sessions of the thesis studies on an emulated one-bit board of 100 V."""

import os
import threading
from contextlib import suppress

import pytest
from command_line import at_the_console, call
from one_bit_board import COMMANDED, LOWEST_V, SUPPLY_V, board_in, check_decoded
from soak import SOAK
from study_texts import changed
from tables import trial_rows

from tactometry.devices.outputs.bit_stream import HEADER_BYTES, decode, word_bytes
from tactometry.experiments.bench.stimuli import bank_on
from tactometry.experiments.data_sets.traces import read_traces
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import builtin, load
from tactometry.records.journal import read
from tactometry.session.request import Press, Slide

SHORT = {
    "time-reversal-threshold": {
        "force_n = [0.5, 1.5, 3.0] ": "force_n = [0.5] ",
        "repeats = 20": "repeats = 1",
        "n_correct = 4 ": "n_correct = 1 ",
        "catch_rate = 0.2": "catch_rate = 0.0",
    },
    "time-reversal-patterns": {
        'form = "attrakdiff" ': 'form = "attrakdiff-haptic" ',
        "n_touches = 3 ": "n_touches = 1 ",
    },
    "hybrid-button": {"repeats = 2": "repeats = 1", "n_touches = 2": "n_touches = 1", "nasa-tlx": "sus"},
}
SOON = ('"500 ms"', '"100 ms"')
WHOLE = {"time-reversal-threshold": 450, "time-reversal-patterns": 7, "hybrid-button": 12}
"""Trials of a session of the built-in study."""
WAYS = {"time-reversal-threshold": "loopback", "time-reversal-patterns": "file", "hybrid-button": "pipe"}
"""A terminal device accepts 4 kB at a time."""
SESSIONS = [(name, way, supply) for name, way in WAYS.items() for supply in ("", COMMANDED)]
"""Sessions with a fixed and with a commanded supply."""
PATIENCE_S = 1000.0 if SOAK else 20.0


def short(name, folder):
    path = folder / f"{name}.toml"
    path.write_text(changed(builtin()[name].read_text("utf-8"), SHORT[name]).replace(*SOON), encoding="utf-8")
    return path


def on_the_console(capsys, monkeypatch, folder, study, *more):
    """Run a console session with the bench in a folder.

    The typed answers alternate between 1 and 5, as some questions do not accept 1.
    """
    bench = ("--bench", folder / "bench.toml")
    return at_the_console(capsys, monkeypatch, study, folder / "d", "1\n5\n" * 5000, *bench, *more)


def streams(content):
    """Decode each stream that a board read, except empty stop streams."""
    at = 0
    while at < len(content):
        version, n_samples = int.from_bytes(content[at + 8 : at + 10], "little"), content[at + 32 : at + 40]
        end = at + HEADER_BYTES + int.from_bytes(n_samples, "little") * version * word_bytes(33)
        signal = decode(content[at:end])
        if signal.samples.size:
            yield signal
        at = end


def read_all(file):
    """Read until the last writer closes; terminal devices then raise OSError."""
    read: list[bytes] = []
    with suppress(OSError):
        while got := os.read(file, 2**20):
            read.append(got)
    os.close(file)
    return b"".join(read)


@pytest.fixture
def emitted(request, tmp_path, in_background):
    """Path of a board, and a function that returns the bytes it read."""
    path = tmp_path / "board"
    if request.param == "file":
        path.touch()
        return path, path.read_bytes
    read_board, done = [], threading.Event()

    def listen(opened):
        read_board.append(read_all(opened()))
        done.set()

    if request.param == "pipe":
        os.mkfifo(path)
        in_background(lambda: listen(lambda: os.open(path, os.O_RDONLY)))
        return path, lambda: read_board[0] if done.wait(PATIENCE_S) else b""
    board, node = os.openpty()
    in_background(lambda: listen(lambda: board))

    def content():
        os.close(node)  # kept open so that the driver can close and reopen the device
        return read_board[0] if done.wait(PATIENCE_S) else b""

    return os.ttyname(node), content


@pytest.mark.parametrize(
    ("name", "emitted", "more"),
    SESSIONS,
    indirect=["emitted"],
    ids=lambda value: "commanded" if value == COMMANDED else None,
)
def test_board_receives_requested_signals_in_full_session(name, emitted, more, tmp_path, capsys, monkeypatch):
    path, content = emitted
    bench, study = board_in(tmp_path, path, more=more), name if SOAK else short(name, tmp_path)
    status, said, _ = on_the_console(capsys, monkeypatch, tmp_path, study)
    assert status == 0, said
    rows = trial_rows(tmp_path / "d")
    assert {row["valid"] for row in rows} == {"1"}
    assert not SOAK or len(rows) >= WHOLE[name]
    assert call(capsys, "validate", tmp_path / "d")[0] == 0
    assert call(capsys, "replay", tmp_path / "d")[0] == 0
    shown = read_traces(tmp_path / "d", int(rows[0]["trial"]), bench=tmp_path / "bench.toml")
    assert [touch.emitted and touch.emitted.digest() for touch in shown] == [touch.answer.digest for touch in shown]
    [journal] = (tmp_path / "d" / "journals").glob("*.jsonl")
    felt = [(asked, answer) for asked, answer in read(journal).entries if isinstance(asked, Press | Slide)]
    blank = [answer.digest for asked, answer in felt if asked.level is None]
    felt = [(asked, answer) for asked, answer in felt if asked.level is not None]
    assert blank == [None] * len(blank)  # the board receives nothing in a trial without a stimulus
    experiment = wire(load(str(study))[0], name)
    checked = set()
    for (asked, answer), signal in zip(felt, streams(content()), strict=True):
        assert answer.digest == signal.digest()
        if (what := (asked.stimulus, asked.level, answer.digest)) not in checked:  # equal signals are checked once
            checked.add(what)
            supply_v = commanded_v(experiment, asked) if more else SUPPLY_V
            check_decoded(experiment.bank[asked.stimulus], asked.level, signal, supply_v)
    assert len(bank_on(experiment, bench)) == len({asked.stimulus for asked, _ in felt})


def commanded_v(experiment, asked):
    """Return the supply voltage, proportional to the level above a minimum."""
    highest = experiment.bounds(asked.stimulus)[1]
    return max(SUPPLY_V * 10 ** ((asked.level - highest) / 20), LOWEST_V)


def checked(capsys, monkeypatch, folder, study):
    """Run `check` with the arguments of `on_the_console`, without a display.

    With a display the command would wait for keys.
    """
    monkeypatch.delenv("DISPLAY", raising=False)
    status, _, found = call(capsys, "check", study, "--bench", folder / "bench.toml", "--out", folder / "d")
    return status, found, ""


TRIED = pytest.mark.parametrize("tried", [checked, on_the_console], ids=["check", "run"])


ABOVE = ("level: found 30.0 dB re 1 um, a focus of 31.62 um", "lower it, lengthen reversal_s, or raise the supply")
BELOW = (
    "level: found 0.3162 V, expected at least 17.89 V, which pulses of 1 sample at the 100 V of the supply",
    "raise the level or the rate of the board, lower its supply, or let the session set the supply (",
    "nothing was played",
)


@TRIED
@pytest.mark.parametrize(
    ("study", "supply_v", "more", "words", "ran"),
    [
        ("time-reversal-threshold", 50.0, "", ABOVE, 3),
        ("time-reversal-threshold", 50.0, COMMANDED, ABOVE, 3),
        ("electrovibration-threshold", 100.0, "", BELOW, 2),
    ],
    ids=["above fixed", "above commanded", "below fixed"],
)
def test_level_outside_board_range_is_refused(tried, study, supply_v, more, words, ran, tmp_path, capsys, monkeypatch):
    (tmp_path / "board").touch()
    board_in(tmp_path, tmp_path / "board", supply_v=supply_v, more=more)
    status, said, _ = tried(capsys, monkeypatch, tmp_path, short(study, tmp_path) if study in SHORT else study)
    assert status == (ran if tried is on_the_console else 3), said
    assert "Traceback" not in said
    assert all(each in said for each in words), said
    assert not list(streams((tmp_path / "board").read_bytes()))
