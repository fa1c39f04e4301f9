"""Stimuli of the thesis studies on a one-bit board."""

from datetime import date

import numpy as np
import pytest
from one_bit_board import COMMANDED, RATE_HZ, SUPPLY_V, board_in, check_decoded
from study_texts import changed, wired

from tactometry.devices.outputs.bit_stream import decode, encode
from tactometry.errors import DeviceFailed, InvalidFile, InvalidParameter
from tactometry.experiments.bench.bench_file import load_bench
from tactometry.experiments.bench.stimuli import bank_on, board_of
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import builtin, load
from tactometry.safety.limits import Limits
from tactometry.signal import Signal


@pytest.mark.parametrize("name", ["time-reversal-threshold", "time-reversal-patterns", "hybrid-button", "force-loss"])
def test_strongest_built_in_stimuli_pass_board_guard(name, tmp_path):
    bench, experiment = board_in(tmp_path, "board"), wire(load(name)[0], name)
    output = bench.devices(experiment.study.limits, date.today()).output
    for strongest in experiment.strongest(bank_on(experiment, bench)):
        limits, final = output.check(strongest.signal)
        assert final.peak == SUPPLY_V <= limits.voltage_peak_v
        assert final.digest() == strongest.signal.digest()


def test_electrovibration_runs_with_commanded_supply(tmp_path):
    """The encoded signal is decoded at levels from -10 to 46 dB re 1 V."""
    changes = {"[30, 60, 120, 180, 240, 320, 480]": "[30, 480]", 'duration_s = "1 s"': 'duration_s = "150 ms"'}
    experiment = wired(changed(builtin()["electrovibration-threshold"].read_text("utf-8"), changes))
    bench = board_in(tmp_path, "board", 200.0, "lowest_supply_v = 1.5")
    output = bench.devices(experiment.study.limits, date.today(), touched=False).output
    for name, made in bank_on(experiment, bench).items():
        for level in (-10.0, 4.5, 46.0):
            _, final = output.check(made.at(level))
            supply_v = max(200.0 * 10 ** ((level - 46.0) / 20), 1.5)
            check_decoded(experiment.bank[name], level, decode(encode(final)), supply_v)


def test_commanded_supply_scales_foci_with_same_bits(tmp_path):
    experiment, bench = wire(load("time-reversal-threshold")[0], "s"), board_in(tmp_path, "board", 100.0, COMMANDED)
    [(name, made)] = bank_on(experiment, bench).items()
    signals = {level: made.at(level) for level in (10.0, 14.0, 22.0, 30.0)}
    for level, signal in signals.items():
        supply_v = max(100.0 * 10 ** ((level - 30.0) / 20), 20.0)
        check_decoded(experiment.bank[name], level, signal, supply_v)
    assert np.array_equal(np.sign(signals[22.0].samples), np.sign(signals[30.0].samples))  # above 20 V
    assert np.count_nonzero(signals[10.0].samples) < np.count_nonzero(signals[14.0].samples)  # below it, bursts


def test_commanded_supply_stays_above_its_lowest_voltage(tmp_path):
    limits = Limits(voltage_peak_v=100.0)
    output = board_in(tmp_path, "board", 100.0, COMMANDED).devices(limits, date.today(), touched=False).output
    bits = np.ones((33, 4))
    for supply_v in (20.0, 73.0, 100.0):
        assert output.driver.final(Signal(supply_v * bits, RATE_HZ, "V")).peak == supply_v
    with pytest.raises(DeviceFailed, match="found a signal of 19 V, expected the 20 to 100 V of the supply"):
        output.driver.final(Signal(19.0 * bits, RATE_HZ, "V"))


def test_lowest_supply_above_supply_is_refused(tmp_path):
    with pytest.raises(InvalidParameter, match=r"output.lowest_supply_v: found 101 V, expected at most the 100 V"):
        board_in(tmp_path, "board", 100.0, "lowest_supply_v = 101.0").devices(
            Limits(voltage_peak_v=100.0), date.today(), touched=False
        )


def test_practice_levels_are_checked_against_the_board(tmp_path):
    changes = {"low = -10.0": "low = 30.0", "high = 46.0": "high = 42.0", "start = 46.0": "start = 40.0"}
    changes["[procedure]"] = "[practice]\nlevels = [20.0]\n[procedure]"
    experiment = wired(changed(builtin()["electrovibration-threshold"].read_text("utf-8"), changes))
    with pytest.raises(InvalidParameter, match="level: found 9.999 V, expected at least 17.89 V"):
        bank_on(experiment, board_in(tmp_path, "board"))


def test_stimuli_are_unchanged_without_a_board(tmp_path):
    experiment, bench = wire(load("hybrid-button")[0], "s"), load_bench(None)
    assert board_of(bench.output) is None
    assert bank_on(experiment, bench) == experiment.bank


def test_electrode_must_be_a_board_channel(tmp_path):
    board_in(tmp_path, "board")
    text = (tmp_path / "bench.toml").read_text().replace("electrode = 4", "electrode = 33")
    (tmp_path / "bench.toml").write_text(text)
    with pytest.raises(InvalidFile, match="electrode: found 33, expected .*32"):
        load_bench(tmp_path / "bench.toml")
