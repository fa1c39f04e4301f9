"""Stimuli generated from the measured impulse responses of a bench."""

from pathlib import Path

import numpy as np
import pytest
from command_line import at_the_console
from short_studies import shortened

from tactometry.devices.outputs.output import RAMP_S, with_ramps
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.experiments.bench.bench_file import parse_bench
from tactometry.experiments.bench.bench_parts import Learnt
from tactometry.experiments.bench.stimuli import bank_of, learnt_facts
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load
from tactometry.provenance import sha256
from tactometry.records.journal import read
from tactometry.session.request import Press
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.focusing.focusing import emitted
from tactometry.stimuli.time_reversal.responses.learning import write_learnt
from tactometry.stimuli.time_reversal.responses.responses import Responses
from tactometry.stimuli.time_reversal.stimulus.setup import Setup


@pytest.fixture(scope="module")
def experiment():
    return wire(load("time-reversal-threshold")[0], "time-reversal-threshold")


@pytest.fixture
def learnt(tmp_path):
    return Learnt(str(tmp_path / "learnt.npz"))


def test_model_stimuli_are_used_without_learnt_responses(experiment):
    assert bank_of(experiment, parse_bench({}).time_reversal) == experiment.bank


def test_true_responses_reproduce_model_signals(experiment, learnt):
    write_responses(learnt.responses)
    bank = bank_of(experiment, parse_bench({"time_reversal": {"responses": learnt.responses}}).time_reversal)
    assert bank.keys() == experiment.bank.keys()
    for name, stimulus in bank.items():
        assert np.allclose(stimulus.at(20.0).samples, experiment.bank[name].at(20.0).samples, rtol=1e-9)


def test_learnt_responses_determine_drive_voltage(experiment, learnt):
    write_responses(learnt.responses, factor=2.0)
    for name, stimulus in bank_of(experiment, learnt).items():
        assert stimulus.at(20.0).peak == pytest.approx(experiment.bank[name].at(20.0).peak / 2, rel=1e-9)


def test_noisy_responses_deliver_level_within_5_percent(experiment, learnt):
    write_responses(learnt.responses, noise_db=40.0)
    true = true_responses()
    [stimulus, *_] = bank_of(experiment, learnt).values()
    moved_m = np.abs(emitted(stimulus.at(20.0), true)).max()
    assert moved_m == pytest.approx(10e-6, rel=0.05)


def test_hybrid_uses_learnt_responses_for_foci_only(learnt):
    """The responses have twice the amplitude, so foci need half the voltage."""
    hybrid = wire(load("hybrid-button")[0], "hybrid-button")
    write_responses(learnt.responses, noise_db=40.0, factor=2.0)
    name = "hybrid, feedback=both"
    learned, modelled = bank_of(hybrid, learnt)[name].at(14.0), hybrid.bank[name].at(14.0)
    np.testing.assert_array_equal(learned.samples[-1], modelled.samples[-1])
    assert np.abs(learned.samples[:-1]).max() == pytest.approx(np.abs(modelled.samples[:-1]).max() / 2, rel=0.05)
    true = true_responses()
    moved_m = np.abs(emitted(Signal(learned.samples[:-1], learned.rate_hz, "V"), true)).max()
    assert moved_m == pytest.approx(10 ** (14.0 / 20) * 1e-6 / 2, rel=0.05)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"n_points": 2}, r"responses: found 2 points of \d+ samples, expected 1 point of at least"),
        (
            {"n_samples": 100},
            "responses: found 1 points of 100 samples, .*learn longer responses, or shorten reversal_s",
        ),
        ({"factor": 1e-3}, "level: found 30.0 dB re 1 um, which needs .* above the 200 V of the amplifier"),
    ],
)
def test_unsuitable_responses_are_refused_before_playback(experiment, learnt, change, message):
    write_responses(learnt.responses, **change)
    with pytest.raises(InvalidParameter, match=rf"^time_reversal.responses, .*learnt.npz, focus: {message}"):
        bank_of(experiment, learnt)


def test_missing_responses_file_is_named(experiment, learnt):
    with pytest.raises(InvalidFile, match=r"learnt.npz"):
        bank_of(experiment, learnt)


def test_session_plays_the_learnt_responses(learnt, tmp_path, capsys, monkeypatch):
    write_responses(learnt.responses, noise_db=40.0, factor=1.5)
    study, bench, played = tmp_path / "s.toml", tmp_path / "bench.toml", tmp_path / "played"
    study.write_text(shortened("time-reversal-threshold"), "utf-8")
    output = f'[output]\nkind = "file"\nfolder = "{played}"\n'
    bench.write_text(f'{output}[time_reversal]\nresponses = "{learnt.responses}"\n', "utf-8")
    status, errors, _ = at_the_console(capsys, monkeypatch, study, tmp_path / "d", "1\n" * 100, "--bench", bench)
    assert status == 0, errors
    [journal] = (tmp_path / "d" / "journals").glob("*.jsonl")
    recording = read(journal)
    assert recording.head.facts["responses_measured"] == "2026-11-20 ZG"
    bank = bank_of(wire(load(str(study))[0], "s.toml"), learnt)
    felt = [(request, answer) for request, answer in recording.entries if isinstance(request, Press) and answer.digest]
    assert felt
    for request, answer in felt:
        assert answer.digest == with_ramps(bank[request.stimulus].at(request.level), RAMP_S).digest()


def test_journal_identifies_the_learnt_responses(learnt):
    write_responses(learnt.responses)
    assert learnt_facts(learnt) == {
        "responses": "learnt.npz",
        "responses_sha256": sha256(Path(learnt.responses).read_bytes()),
        "responses_measured": " ".join(PROVENANCE.values()),
    }
    assert learnt_facts(None) == {}


PROVENANCE = {"measured_on": "2026-11-20", "measured_by": "ZG"}


def true_responses():
    setup = Setup()
    return setup.responses_at(*setup.focus_m)


def write_responses(path, *, noise_db=np.inf, factor=1.0, n_samples=None, n_points=1):
    """Write them with noise so many dB below, and changed as asked: what was written."""
    true = true_responses()
    rms = np.sqrt(np.mean(true.samples**2))
    noise = rms * 10 ** (-noise_db / 20) * np.random.default_rng(5).standard_normal(true.samples.shape)
    samples = np.tile(factor * (true.samples + noise)[..., :n_samples], (n_points, 1, 1))
    write_learnt(Responses(samples, true.rate_hz), Path(path), PROVENANCE)
    return samples
