"""A one-bit board of 33 channels for plate and electrode, and what a stream must hold that it decodes."""

from dataclasses import replace

import numpy as np
import pytest
from benches import gain_toml

from tactometry.experiments.bench.bench_file import load_bench
from tactometry.stimuli.electrovibration.waveforms.amplitude_modulated import AmplitudeModulated
from tactometry.stimuli.hybrid import Hybrid
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain

SUPPLY_V = 100.0
RATE_HZ, CAPACITANCE_F, PER_VOLT_M = 250e3, 5e-9, 1e-8
DURATION_S, CURRENT_A, DISPLACEMENT_M = 1.0, 0.5, 100e-6
BOARD = f"""
[output]
kind = "packed"
path = "{{path}}"
n_channels = 33
rate_hz = "250 kHz"
electrode = 4
ungated = true
{{more}}
{{gain}}
[output.load]
kind = "piezo"
capacitance_f = {CAPACITANCE_F}
displacement_m_per_v = [{PER_VOLT_M}]
[limits]
voltage_peak_v = {{supply_v}}
duration_s = {DURATION_S}
current_peak_a = {CURRENT_A}
displacement_peak_m = {DISPLACEMENT_M}
duty = 1.0
session_s = "45 min"
"""
LOWEST_V = 20.0
COMMANDED = f"lowest_supply_v = {LOWEST_V}"
ELECTRODE, PLATES = 4, [channel for channel in range(33) if channel != 4]


def board_in(folder, path, supply_v=SUPPLY_V, more=""):
    gain = gain_toml(f"packed {path}", supply_v, 1.0)
    text = BOARD.format(path=path, more=more, gain=gain, supply_v=supply_v)
    (folder / "bench.toml").write_text(text, encoding="utf-8")
    return load_bench(folder / "bench.toml")


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
