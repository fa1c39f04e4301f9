"""A bench on which a texture follows a finger that a UDP sensor measures, into a sound server; a study on it."""

from itertools import product

import numpy as np
from benches import UDP_HAND, gain_toml
from study_texts import changed
from tables import trial_rows
from window_sitting import python

from tactometry.experiments.data_sets.traces import read_traces
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load, parse
from tactometry.position_dependent import felt_under
from tactometry.signal import Signal

FULL_SCALE_V = 100.0

METRES_PER_COUNT = 5e-5
"""Metres per sample of the emulator at 1 kHz: the finger moves at 50 mm/s."""
RELEASED = "0.5:30,3:100"

BENCH = (
    """
[screen]
fullscreen = false
dry_run = false
[output]
kind = "audio"
device = "pulse"
shared = true
rate_hz = 48000
sample_format = "int16"
latency_s = 0.02
{more}
{gain}
[output.load]
kind = "electrode"
capacitance_f = "1 nF"
[limits]
voltage_peak_v = 80.0
duration_s = 30.0
current_peak_a = "5 mA"
duty = 1.0
session_s = "1 h"
stop_within_s = "500 ms"
"""
    + UDP_HAND
)
POSITION = f"""
[position]
sensor = "hand"
channels = [0]
metres_per_count = {METRES_PER_COUNT}
"""
SHORT = {
    "period_m = [0.0005, 0.001, 0.002, 0.004]": "period_m = [0.002]",
    '"0.0005" = { stimulus = { texture = { period_m = "0.5 mm" } } }\n': "",
    '"0.001" = { stimulus = { texture = { period_m = "1 mm" } } }\n': "",
    '"0.004" = { stimulus = { texture = { period_m = "4 mm" } } }\n': "",
    "levels = [22, 28, 34, 40, 46]": "levels = [34]",
    'duration_s = "1 s"': 'duration_s = "500 ms"\nrate_hz = 48000',
    "catch_rate = 0.1": "catch_rate = 0.0\nn_attempts = 60",  # A busy machine tears many touches.
    "repeats = 4": "repeats = 2",
    "voltage_peak_v = 200.0": "voltage_peak_v = 80.0",
}


def texture_study(folder, changes=None):
    """A file with a short study of a square grating of 2 mm: 25 periods a second at 50 mm/s."""
    text = changed(load("grating-roughness")[1].decode(), SHORT | (changes or {}))
    (folder / "texture.toml").write_text(text, encoding="utf-8")
    return folder / "texture.toml"


def texture_bench(folder, port, position=POSITION, more=""):
    gain = gain_toml("audio pulse, int16", system_volume=1.0)
    (folder / "bench.toml").write_text(BENCH.format(port=port, gain=gain, more=more) + position, encoding="utf-8")
    return folder / "bench.toml"


def console_session(study, bench, out, env, n_answers=50):
    words = ("run", study, "--participant", "P01", "--rig", "console", "--bench", bench, "--out", out)
    done = python("-m", "tactometry", *words, env=env, input="1\n" * n_answers)
    return done.returncode, done.stdout, done.stderr


def paths_in(root):
    """Return the texture paths of a data set by digest: times and places."""
    (file,) = (root / "journals").glob("*_positions.tsv")
    rows = [line.split("\t") for line in file.read_text().splitlines()[1:]]
    digests = dict.fromkeys(digest for digest, _, _ in rows)
    return {name: np.array([[float(t), float(x)] for digest, t, x in rows if digest == name]).T for name in digests}


def stretches(frames, least=4800):
    heard = np.flatnonzero(frames.any(axis=1))
    cuts = np.flatnonzero(np.diff(heard) > least)
    firsts, lasts = np.r_[heard[:1], heard[cuts + 1]], np.r_[heard[cuts], heard[-1:]]
    return [frames[first : last + 1] for first, last in zip(firsts, lasts, strict=True)]


def touches_heard_as_asked(study, data, frames):
    """Return the rows of all touches of a session, of which the sink heard one as its places in the data set ask for.

    Without gaps it heard each touch; a busy sound server tears one into several stretches, which no program notices.
    """
    rows, paths = trial_rows(data), paths_in(data)
    touched = [row for row in rows if row["positions_digest"]]
    assert len(touched) >= 2, rows
    [stimulus, *_] = wire(parse(study.read_bytes(), "s.toml"), "s.toml").bank.values()
    heard = stretches(frames)
    assert len(heard) >= len(touched) or any(row["n_gaps"] != "0" for row in touched)
    sound = [row for row in touched if (row["valid"], row["positions_late"]) == ("1", "0")]
    wanted = [numbers_of(stimulus, paths[row["positions_digest"]]) for row in sound]
    assert any(alike(record[:, 0].astype(float), numbers) for numbers, record in product(wanted, heard)), rows
    return touched


def check_kept_as_heard(data, frames):
    """Check that a touch was recorded exactly as the sink received it.

    One touch of a session suffices: a busy sound server drops samples.
    """
    trials = dict.fromkeys(int(row["trial"]) for row in trial_rows(data))
    touches = [touch for trial in trials for touch in read_traces(data, trial) if touch.answer.digest]
    numbers = [np.rint(touch.emitted.samples[0] / FULL_SCALE_V * 32767) for touch in touches]
    pairs = product(numbers, stretches(frames))
    assert any(np.array_equal(stretches(kept[:, None])[0][:, 0], record[:, 0]) for kept, record in pairs)


def numbers_of(stimulus, path):
    """Return the expected 16-bit samples (n_frames,) of a finger path."""
    strongest = stimulus.at(34.0)
    k = np.trunc(strongest.samples / FULL_SCALE_V * 32767)
    return np.trunc(felt_under(stimulus, Signal(k, strongest.rate_hz, "V"), *path).samples[0])


def alike(record, wanted):
    """Return True if both are equal above one of some thresholds.

    Positions are recorded rounded, which moves an edge of 48 samples by at most one sample.
    """
    return any(_alike_above(threshold, record, wanted) for threshold in (100, 150, 200))


def _alike_above(threshold, record, wanted):
    ends = (np.flatnonzero(np.abs(samples) > threshold)[[0, -1]] for samples in (record, wanted))
    record, wanted = (samples[first : last + 1] for samples, (first, last) in zip((record, wanted), ends, strict=True))
    return len(record) == len(wanted) and np.abs(record - wanted).max() <= 2 + np.abs(wanted).max() / 47
