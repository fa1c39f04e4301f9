"""Applied force: current samples open the gate, old stamps mean silence."""

import time

import numpy as np
import pytest

from tactometry.gates import ForceGate
from tactometry.rigs.touch.gated_samples import SILENT_S, AppliedForce

NOTHING = np.empty(0)


@pytest.fixture
def force():
    return AppliedForce(ForceGate(target_n=1.0, tolerance=0.2, hold_s=0.2))


def hold_that_ended(force, ago_s):
    times_s = time.perf_counter() - ago_s - np.arange(300)[::-1] / 1000
    force.on_samples(times_s, np.ones(300))


def opens_now(force):
    """Return True if the gate opens on samples that arrive as they are taken."""
    begin_s = last_s = time.perf_counter()
    hold_that_ended(force, 0.0)
    while time.perf_counter() < begin_s + 20.0:
        last_s, since_s = time.perf_counter(), last_s
        times_s = np.arange(since_s, last_s, 1e-3)
        force.on_samples(times_s, np.ones(len(times_s)))
        if force.open:
            return last_s >= begin_s + 0.2
        time.sleep(5e-3)
    return False


def test_gate_opens_when_samples_are_current(force):
    assert opens_now(force)


def test_old_samples_open_no_gate_and_mean_silence(force):
    """The samples are 101 ms old; the next empty read detects the silence."""
    hold_that_ended(force, SILENT_S + 1e-3)
    assert not force.open
    assert not force.silent
    force.on_samples(NOTHING, NOTHING)
    assert force.silent
    assert opens_now(force)


def test_future_stamps_do_not_hide_silence(force):
    hold_that_ended(force, -5.0)
    time.sleep(SILENT_S + 1e-3)
    force.on_samples(NOTHING, NOTHING)
    assert force.silent
    assert not force.open
