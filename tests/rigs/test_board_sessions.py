"""The studies of the thesis on a one-bit board of 100 V: what leaves is decoded, and is what was asked for."""

import io
import os
import re
import threading
from contextlib import suppress
from dataclasses import replace
from datetime import date

import numpy as np
import pytest
from benches import gain_toml
from command_line import call
from soak import SOAK
from study_texts import changed
from tables import trial_rows

from tactometry.devices.outputs.bit_stream import HEADER_BYTES, decode, encode, word_bytes
from tactometry.errors import DeviceFailed, InvalidFile, InvalidParameter
from tactometry.experiments.bench.bench_file import load_bench
from tactometry.experiments.bench.stimuli import bank_on, board_of
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import builtin, load
from tactometry.records.journal import read
from tactometry.safety.limits import Limits
from tactometry.session.request import Press, Slide
from tactometry.signal import Signal
from tactometry.stimuli.electrovibration.waveforms.amplitude_modulated import AmplitudeModulated
from tactometry.stimuli.hybrid import Hybrid
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain

SUPPLY_V = 100.0
RATE_HZ, CAPACITANCE_F, PER_VOLT_M = 250e3, 5e-9, 1e-8
DURATION_S, CURRENT_A, DISPLACEMENT_M = 1.0, 0.5, 100e-6
BOARD = """
[output]
kind = "packed"
path = "{path}"
n_channels = 33
rate_hz = "250 kHz"
electrode = 4
ungated = true
{more}
{gain}
[output.load]
kind = "piezo"
capacitance_f = {capacitance_f}
displacement_m_per_v = [{per_volt_m}]
[limits]
voltage_peak_v = {supply_v}
duration_s = {duration_s}
current_peak_a = {current_a}
displacement_peak_m = {displacement_m}
duty = 1.0
session_s = "45 min"
"""
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
LOOPED = tuple(WHOLE) if SOAK else ("time-reversal-threshold",)
"""A terminal device takes 4 kB at a time: on a busy machine not each stream of the others in its time."""
LOWEST_V = 20.0
COMMANDED = f"lowest_supply_v = {LOWEST_V}"
FIXED = [*((name, way, "") for name in WHOLE for way in ("file", "pipe")), *((name, "loopback", "") for name in LOOPED)]
WAYS = {"time-reversal-threshold": "loopback", "time-reversal-patterns": "file", "hybrid-button": "pipe"}
SESSIONS = FIXED + [(name, way, COMMANDED) for name, way, _ in FIXED if SOAK or WAYS[name] == way]
"""With one supply each way; with one that is commanded each way at full size."""
PATIENCE_S = 1000.0 if SOAK else 20.0
ELECTRODE, PLATES = 4, [channel for channel in range(33) if channel != 4]


def board_in(folder, path, supply_v=SUPPLY_V, more=""):
    text = BOARD.format(
        path=path,
        more=more,
        gain=gain_toml(f"packed {path}", supply_v, 1.0),
        capacitance_f=CAPACITANCE_F,
        per_volt_m=PER_VOLT_M,
        supply_v=supply_v,
        duration_s=DURATION_S,
        current_a=CURRENT_A,
        displacement_m=DISPLACEMENT_M,
    )
    (folder / "bench.toml").write_text(text, encoding="utf-8")
    return load_bench(folder / "bench.toml")


def short(name, folder):
    path = folder / f"{name}.toml"
    path.write_text(changed(builtin()[name].read_text("utf-8"), SHORT[name]).replace(*SOON), encoding="utf-8")
    return path


def on_the_console(capsys, monkeypatch, folder, study, *more):
    """A session with the bench in a folder; where 1 is no answer, as of a load in steps of 5, the next line is."""
    monkeypatch.setattr("sys.stdin", io.StringIO("1\n5\n" * 5000))
    words = ("run", study, "--participant", "P01", "--rig", "console", "--bench", folder / "bench.toml")
    return call(capsys, *words, "--out", folder / "d", *more)


def streams(content):
    """Every stream that a board read, decoded one by one; those that stop are left out."""
    at = 0
    while at < len(content):
        version, n_samples = int.from_bytes(content[at + 8 : at + 10], "little"), content[at + 32 : at + 40]
        end = at + HEADER_BYTES + int.from_bytes(n_samples, "little") * version * word_bytes(33)
        signal = decode(content[at:end])
        if signal.samples.size:
            yield signal
        at = end


def read_all(file):
    """What comes until nobody writes any more, which a terminal tells by an error."""
    read: list[bytes] = []
    with suppress(OSError):
        while got := os.read(file, 2**20):
            read.append(got)
    os.close(file)
    return b"".join(read)


@pytest.fixture
def emitted(request, tmp_path, in_background):
    """Where a board reads, and what it read when the session is over; the bytes of a device node come back."""
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
        os.close(node)  # without another end that is open, the driver's closing would be the end of the file
        return read_board[0] if done.wait(PATIENCE_S) else b""

    return os.ttyname(node), content


@pytest.mark.parametrize(
    ("name", "emitted", "more"),
    SESSIONS,
    indirect=["emitted"],
    ids=lambda value: "commanded" if value == COMMANDED else None,
)
def test_a_session_is_complete_and_the_board_decodes_what_was_asked_for(
    name, emitted, more, tmp_path, capsys, monkeypatch
):
    """At full size the studies as they are built in, each trial of them."""
    path, content = emitted
    bench, study = board_in(tmp_path, path, more=more), name if SOAK else short(name, tmp_path)
    status, said, _ = on_the_console(capsys, monkeypatch, tmp_path, study)
    assert status == 0, said
    rows = trial_rows(tmp_path / "d")
    assert {row["valid"] for row in rows} == {"1"}
    assert not SOAK or len(rows) >= WHOLE[name]
    assert call(capsys, "validate", tmp_path / "d")[0] == 0
    assert call(capsys, "replay", tmp_path / "d")[0] == 0
    [journal] = (tmp_path / "d" / "journals").glob("*.jsonl")
    felt = [(asked, answer) for asked, answer in read(journal).entries if isinstance(asked, Press | Slide)]
    blank = [answer.digest for asked, answer in felt if asked.level is None]
    felt = [(asked, answer) for asked, answer in felt if asked.level is not None]
    assert blank == [None] * len(blank)  # of a trial without a stimulus the board reads nothing
    experiment = wire(load(str(study))[0], name)
    checked = set()
    for (asked, answer), signal in zip(felt, streams(content()), strict=True):
        assert answer.digest == signal.digest()
        if (what := (asked.stimulus, asked.level, answer.digest)) not in checked:  # of equal ones one is enough
            checked.add(what)
            supply_v = commanded_v(experiment, asked) if more else SUPPLY_V
            check_decoded(experiment.bank[asked.stimulus], asked.level, signal, supply_v)
    assert len(bank_on(experiment, bench)) == len({asked.stimulus for asked, _ in felt})


def commanded_v(experiment, asked):
    """In proportion to the level, from the highest of the stimulus down to the lowest supply."""
    highest = experiment.bounds(asked.stimulus)[1]
    return max(SUPPLY_V * 10 ** ((asked.level - highest) / 20), LOWEST_V)


def check_decoded(stimulus, level, signal, supply_v=SUPPLY_V):
    """Foci by the responses of the plate, the electrode by its mean square, and the limits of the bench."""
    check_limits(signal)
    assert set(np.unique(np.abs(signal.samples))) <= {0.0, signal.peak}
    assert signal.peak == pytest.approx(supply_v)
    foci, electrode = signal.samples[PLATES], signal.samples[ELECTRODE]
    match stimulus:
        case FocusTrain():
            assert not electrode.any()
            check_foci(stimulus, level, foci)
        case AmplitudeModulated():
            assert not foci.any()
            check_pulses(stimulus, level, electrode, supply_v)
        case Hybrid():
            check_foci(stimulus.focus, level, foci)
            check_pulses(stimulus.friction, level + stimulus.electrode_offset_db, electrode, supply_v)


def check_limits(signal):
    steps = np.diff(np.pad(signal.samples, ((0, 0), (1, 1))), axis=1)
    assert signal.duration_s <= DURATION_S
    assert CAPACITANCE_F * np.abs(steps).max() * signal.rate_hz <= CURRENT_A
    assert PER_VOLT_M * np.abs(signal.samples).max(axis=1).sum() <= DISPLACEMENT_M


def check_foci(train, level, drives):
    """Each focus of the pattern, at its instant, by a plain sum over what was emitted before it."""
    heard = train.setup.responses_at(*train.setup.focus_m).samples[0]
    n_reversal = round(train.emission_s * RATE_HZ)
    instants = np.round(train.foci.times_s * RATE_HZ).astype(int) + n_reversal - 1
    made_m = [displacement_m(drives, heard, instant) for instant in instants]
    asked_m = 1e-6 * 10 ** (level / 20) * train.foci.weights
    np.testing.assert_allclose(made_m, asked_m, atol=0.01 * np.abs(asked_m).max())


def displacement_m(drives, heard, instant):
    n = min(instant + 1, heard.shape[1])
    return np.sum(drives[:, instant - n + 1 : instant + 1][:, ::-1] * heard[:, :n])


def check_pulses(waveform, level, pulses, supply_v):
    """The square of the voltage, summed to the end of any half period of the carrier, to half a sample."""
    asked = replace(waveform, rate_hz=RATE_HZ).at(level).samples[0]
    ends = np.flatnonzero(np.diff(np.sign(asked)))
    owed = np.cumsum(asked**2 - pulses[: len(asked)] ** 2)[ends]
    assert np.abs(owed).max() <= 0.501 * supply_v**2


@pytest.mark.parametrize("name", ["time-reversal-threshold", "time-reversal-patterns", "hybrid-button", "force-loss"])
def test_every_strongest_stimulus_of_a_built_in_study_passes_the_guard_of_a_board_of_100_v(name, tmp_path):
    bench, experiment = board_in(tmp_path, "board"), wire(load(name)[0], name)
    output = bench.devices(experiment.study.limits, date.today()).output
    for strongest in experiment.strongest(bank_on(experiment, bench)):
        limits, final = output.check(strongest.signal)
        assert final.peak == SUPPLY_V <= limits.voltage_peak_v
        assert final.digest() == strongest.signal.digest()


def checked(capsys, monkeypatch, folder, study):
    """As `on_the_console`; without a display, whose keys would be waited for."""
    monkeypatch.delenv("DISPLAY", raising=False)
    status, _, found = call(capsys, "check", study, "--bench", folder / "bench.toml", "--out", folder / "d")
    return status, found, ""


TRIED = pytest.mark.parametrize("tried", [checked, on_the_console], ids=["check", "run"])


@TRIED
@pytest.mark.parametrize("more", ["", "lowest_supply_v = 20.0"], ids=["fixed", "commanded"])
def test_a_level_above_the_board_is_refused_before_anything_plays(tried, more, tmp_path, capsys, monkeypatch):
    (tmp_path / "board").touch()
    board_in(tmp_path, tmp_path / "board", supply_v=50.0, more=more)
    status, said, _ = tried(capsys, monkeypatch, tmp_path, short("time-reversal-threshold", tmp_path))
    assert status == 3, said
    assert "Traceback" not in said
    assert "level: found 30.0 dB re 1 um, a focus of 31.62 um" in said
    assert "lower it, lengthen reversal_s, or raise the supply" in said
    assert not list(streams((tmp_path / "board").read_bytes()))


@TRIED
def test_electrovibration_below_a_fixed_supply_is_refused_with_the_cure(tried, tmp_path, capsys, monkeypatch):
    (tmp_path / "board").touch()
    board_in(tmp_path, tmp_path / "board")
    status, said, _ = tried(capsys, monkeypatch, tmp_path, "electrovibration-threshold")
    assert status != 0
    assert (
        "level: found 0.3162 V, expected at least 17.89 V, which pulses of 1 sample at the 100 V of the supply" in said
    )
    assert "raise the level or the rate of the board, or lower its supply or command it (lowest_supply_v" in said
    assert "nothing was played" in said
    assert not list(streams((tmp_path / "board").read_bytes()))


# --- a supply that is commanded


def test_electrovibration_runs_on_a_board_whose_supply_is_commanded(tmp_path):
    """From -10 to 46 dB re 1 V: what the driver would emit is decoded."""
    text = builtin()["electrovibration-threshold"].read_text("utf-8")
    changes = {"[30, 60, 120, 180, 240, 320, 480]": "[30, 480]", 'duration_s = "1 s"': 'duration_s = "150 ms"'}
    (tmp_path / "study.toml").write_text(changed(text, changes), encoding="utf-8")
    study, _ = load(str(tmp_path / "study.toml"))
    experiment, bench = wire(study, "s"), board_in(tmp_path, "board", 200.0, "lowest_supply_v = 1.5")
    output = bench.devices(study.limits, date.today(), touched=False).output
    for name, made in bank_on(experiment, bench).items():
        for level in (-10.0, 4.5, 46.0):
            _, final = output.check(made.at(level))
            supply_v = max(200.0 * 10 ** ((level - 46.0) / 20), 1.5)
            check_decoded(experiment.bank[name], level, decode(encode(final)), supply_v)


def test_a_commanded_supply_makes_foci_of_every_level_by_the_same_bits(tmp_path):
    experiment, bench = wire(load("time-reversal-threshold")[0], "s"), board_in(tmp_path, "board", 100.0, COMMANDED)
    [(name, made)] = bank_on(experiment, bench).items()
    signals = {level: made.at(level) for level in (10.0, 14.0, 22.0, 30.0)}
    for level, signal in signals.items():
        supply_v = max(100.0 * 10 ** ((level - 30.0) / 20), 20.0)
        check_decoded(experiment.bank[name], level, signal, supply_v)
    assert np.array_equal(np.sign(signals[22.0].samples), np.sign(signals[30.0].samples))  # above 20 V
    assert np.count_nonzero(signals[10.0].samples) < np.count_nonzero(signals[14.0].samples)  # below it, bursts


class Supplying:
    """A board at the end of a pipe, which plays until it is to set a supply below one that it reaches; then it closes
    its line, or waits for its supply with no eye on the line."""

    def __init__(self, pipe, lowest_v, *, closes):
        self.pipe, self.lowest_v, self.closes = pipe, lowest_v, closes
        self.n_played, self.ended = 0, threading.Event()

    def run(self):
        with self.pipe.open("rb") as line:
            while header := line.read(HEADER_BYTES):
                [supply_v], n_samples = np.frombuffer(header[24:32]), int.from_bytes(header[32:40], "little")
                if n_samples and supply_v < self.lowest_v:
                    break
                line.read(n_samples * int.from_bytes(header[8:10], "little") * word_bytes(33))
                self.n_played += n_samples > 0
            if header and not self.closes:
                self.ended.wait(PATIENCE_S)


@pytest.mark.parametrize(
    ("closes", "words"),
    [
        (True, r"board: the board (took no more \(Broken pipe\); the output stopped|had not read all of a stream)"),
        (False, "what was asked for before this was not played"),
    ],
    ids=["a supply that is refused", "a supply that does not come"],
)
def test_a_supply_that_fails_ends_the_session_and_loses_nothing(
    closes, words, tmp_path, capsys, monkeypatch, in_background
):
    """A board whose supply does not come was taken to have played: its trials were valid, with nothing on the plate."""
    pipe, study = tmp_path / "board", short("time-reversal-threshold", tmp_path)
    os.mkfifo(pipe)
    board_in(tmp_path, pipe, more=COMMANDED)
    failing = Supplying(pipe, 60.0, closes=closes)
    in_background(failing.run)
    status, said, _ = on_the_console(capsys, monkeypatch, tmp_path, study)
    failing.ended.set()
    assert status == 3, said
    assert re.search(words, said), said
    assert "Traceback" not in said
    kept = trial_rows(tmp_path / "d")
    assert {row["level"] for row in kept if row["valid"] == "1"} <= {"26", "30"}  # of 63 and 100 V
    sound = Supplying(pipe, LOWEST_V * (1 - 1e-9), closes=True)
    in_background(sound.run)
    status, said, _ = on_the_console(capsys, monkeypatch, tmp_path, study, "--resume")
    assert status == 0, said
    rows = trial_rows(tmp_path / "d")
    assert len(kept) < len(rows)
    assert rows[: len(kept)] == kept
    assert call(capsys, "validate", tmp_path / "d")[0] == 0


def test_a_board_that_says_no_supply_below_its_own_keeps_it(tmp_path):
    limits = Limits(voltage_peak_v=100.0)
    output = board_in(tmp_path, "board", 100.0, COMMANDED).devices(limits, date.today(), touched=False).output
    bits = np.ones((33, 4))
    for supply_v in (20.0, 73.0, 100.0):
        assert output.driver.final(Signal(supply_v * bits, RATE_HZ, "V")).peak == supply_v
    with pytest.raises(DeviceFailed, match="found a signal of 19 V, expected the 20 to 100 V of the supply"):
        output.driver.final(Signal(19.0 * bits, RATE_HZ, "V"))


def test_a_supply_lower_than_the_lowest_is_refused(tmp_path):
    with pytest.raises(InvalidParameter, match=r"output.lowest_supply_v: found 101 V, expected at most the 100 V"):
        board_in(tmp_path, "board", 100.0, "lowest_supply_v = 101.0").devices(
            Limits(voltage_peak_v=100.0), date.today(), touched=False
        )


def test_the_lowest_level_of_practice_is_made_too(tmp_path):
    text = builtin()["electrovibration-threshold"].read_text("utf-8")
    changes = {"low = -10.0": "low = 30.0", "high = 46.0": "high = 42.0", "start = 46.0": "start = 40.0"}
    changes["[procedure]"] = PRACTICE
    (tmp_path / "study.toml").write_text(changed(text, changes), encoding="utf-8")
    study, _ = load(str(tmp_path / "study.toml"))
    with pytest.raises(InvalidParameter, match="level: found 9.999 V, expected at least 17.89 V"):
        bank_on(wire(study, "s"), board_in(tmp_path, "board"))


PRACTICE = "[practice]\nlevels = [20.0]\n[procedure]"


def test_a_level_below_the_board_is_refused_before_anything_plays(tmp_path):
    study, _ = load("electrovibration-threshold")
    with pytest.raises(InvalidParameter, match="^output, amplitude_modulated.*: level: found .*; nothing was played$"):
        bank_on(wire(study, "s"), board_in(tmp_path, "board"))


def test_without_a_board_the_stimuli_are_those_of_the_study(tmp_path):
    experiment, bench = wire(load("hybrid-button")[0], "s"), load_bench(None)
    assert board_of(bench.output) is None
    assert bank_on(experiment, bench) == experiment.bank


def test_an_electrode_is_a_channel_of_the_board(tmp_path):
    board_in(tmp_path, "board")
    text = (tmp_path / "bench.toml").read_text().replace("electrode = 4", "electrode = 33")
    (tmp_path / "bench.toml").write_text(text)
    with pytest.raises(InvalidFile, match="electrode: found 33, expected .*32"):
        load_bench(tmp_path / "bench.toml")
