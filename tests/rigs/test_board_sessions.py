"""The studies of the thesis on a one-bit board of 100 V: what leaves is decoded, and is what was asked for."""

import io
import os
import threading
from datetime import date

import numpy as np
import pytest
from benches import gain_toml
from command_line import call
from scipy.signal import fftconvolve
from study_texts import changed
from tables import trial_rows

from tactometry.devices.outputs.bit_stream import HEADER_BYTES, decode, word_bytes
from tactometry.errors import InvalidParameter
from tactometry.experiments.bench.bench_file import load_bench
from tactometry.experiments.bench.stimuli import bank_on, board_of
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import builtin, load
from tactometry.records.journal import read
from tactometry.session.request import Press, Slide
from tactometry.stimuli.time_reversal.stimulus.setup import Setup

SUPPLY_V = 100.0
BOARD = """
[output]
kind = "packed"
path = "{path}"
n_channels = 33
rate_hz = "250 kHz"
electrode = 4
ungated = true
{gain}
[output.load]
kind = "piezo"
capacitance_f = "5 nF"
displacement_m_per_v = [1e-8]
[limits]
voltage_peak_v = {supply_v}
duration_s = 1.0
current_peak_a = 0.5
displacement_peak_m = "100 um"
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
ELECTRODE, PLATES = 4, [channel for channel in range(33) if channel != 4]


def board_in(folder, path, supply_v=SUPPLY_V):
    gain = gain_toml(f"packed {path}", supply_v, 1.0)
    (folder / "bench.toml").write_text(BOARD.format(path=path, gain=gain, supply_v=supply_v), encoding="utf-8")
    return load_bench(folder / "bench.toml")


def short(name, folder):
    path = folder / f"{name}.toml"
    path.write_text(changed(builtin()[name].read_text("utf-8"), SHORT[name]).replace(*SOON), encoding="utf-8")
    return path


def streams(content):
    """Every stream that a board read, decoded; those that stop are left out."""
    signals, at = [], 0
    while at < len(content):
        version, n_samples = int.from_bytes(content[at + 8 : at + 10], "little"), content[at + 32 : at + 40]
        end = at + HEADER_BYTES + int.from_bytes(n_samples, "little") * version * word_bytes(33)
        signals.append(decode(content[at:end]))
        at = end
    return [signal for signal in signals if signal.samples.size]


@pytest.fixture(params=["file", "pipe"])
def emitted(request, tmp_path, in_background):
    """Where a board reads, and what it read when the session is over."""
    path, got = tmp_path / "board", []
    if request.param == "file":
        path.touch()
        return path, path.read_bytes
    os.mkfifo(path)
    done = threading.Event()

    def listen():
        got.append(path.read_bytes())
        done.set()

    in_background(listen)
    return path, lambda: got[0] if done.wait(20) else b""


@pytest.mark.parametrize("name", SHORT)
def test_a_session_is_complete_and_the_board_decodes_what_was_asked_for(name, emitted, tmp_path, capsys, monkeypatch):
    path, content = emitted
    bench, study = board_in(tmp_path, path), short(name, tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO("1\n" * 400))
    words = ("run", study, "--participant", "P01", "--rig", "console", "--bench", tmp_path / "bench.toml")
    status, said, _ = call(capsys, *words, "--out", tmp_path / "d")
    assert status == 0, said
    assert {row["valid"] for row in trial_rows(tmp_path / "d")} == {"1"}
    assert call(capsys, "validate", tmp_path / "d")[0] == 0
    assert call(capsys, "replay", tmp_path / "d")[0] == 0
    [journal] = (tmp_path / "d" / "journals").glob("*.jsonl")
    felt = [(asked, answer) for asked, answer in read(journal).entries if isinstance(asked, Press | Slide)]
    played = streams(content())
    assert [signal.digest() for signal in played] == [answer.digest for _, answer in felt]
    for (asked, _), signal in zip(felt, played, strict=True):
        check_decoded(asked, signal)
    assert len(bank_on(wire(load(str(study))[0], name), bench)) == len({asked.stimulus for asked, _ in felt})


def check_decoded(asked, signal):
    """Foci by the responses of the plate, the electrode by its mean square."""
    assert set(np.unique(signal.samples)) <= {-SUPPLY_V, 0.0, SUPPLY_V}
    foci, electrode = signal.samples[PLATES], signal.samples[ELECTRODE]
    setup = Setup()
    [heard] = setup.responses_at(*setup.focus_m).samples
    largest_m = np.abs(sum(fftconvolve(*pair) for pair in zip(foci, heard, strict=True))).max()
    if asked.stimulus.startswith("amplitude_modulated"):
        assert not foci.any()
    else:
        assert 20 * np.log10(largest_m / 1e-6) == pytest.approx(asked.level, abs=0.1)
    if "electrovibration" in asked.stimulus:
        assert electrode.any()
    elif "hybrid" not in asked.stimulus:
        assert not electrode.any()


@pytest.mark.parametrize("name", ["time-reversal-threshold", "time-reversal-patterns", "hybrid-button", "force-loss"])
def test_every_strongest_stimulus_of_a_built_in_study_passes_the_guard_of_a_board_of_100_v(name, tmp_path):
    bench, experiment = board_in(tmp_path, "board"), wire(load(name)[0], name)
    output = bench.devices(experiment.study.limits, date.today()).output
    for strongest in experiment.strongest(bank_on(experiment, bench)):
        limits, final = output.check(strongest.signal)
        assert final.peak == SUPPLY_V <= limits.voltage_peak_v
        assert final.digest() == strongest.signal.digest()


def test_a_level_above_the_board_is_refused_before_anything_plays(tmp_path, capsys, monkeypatch):
    (tmp_path / "board").touch()
    board_in(tmp_path, tmp_path / "board", supply_v=50.0)
    monkeypatch.setattr("sys.stdin", io.StringIO("1\n" * 400))
    study = short("time-reversal-threshold", tmp_path)
    words = ("run", study, "--participant", "P01", "--rig", "console", "--bench", tmp_path / "bench.toml")
    status, said, _ = call(capsys, *words, "--out", tmp_path / "d")
    assert status == 3
    assert "level: found 30.0 dB re 1 um, a focus of 31.62 um" in said
    assert "lower it, lengthen reversal_s, or raise the supply" in said
    assert (tmp_path / "board").read_bytes() == b""


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
    with pytest.raises(Exception, match="electrode: found 33, expected .*32"):
        load_bench(tmp_path / "bench.toml")
