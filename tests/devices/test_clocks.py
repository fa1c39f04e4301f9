"""Device clocks: repeated samples, wrong rates, implausible stamps."""

import math
import time

import numpy as np
import pytest
from hard_cases import exact_case
from hypothesis import given, strategies as st

from tactometry.devices.clock_map import ClockMap, clock_offset_s
from tactometry.devices.sensors.counted_samples import CountedSamples
from tactometry.devices.sensors.reader import AHEAD_S, LATE_FOR_S, LATE_S, Arrivals, Reader, SampleBlock, Source
from tactometry.errors import DeviceFailed


@given(st.lists(st.tuples(st.integers(0, 40), st.booleans()), max_size=60))
def test_repeated_samples_are_counted_and_ignored(repeats):
    straight, torn = CountedSamples(1e-3, settling_s=0.0), CountedSamples(1e-3, settling_s=0.0)
    for n, (back, beside) in enumerate(repeats, start=50):
        sample, again, arrival_s = (n, n, (n,)), (n - back, n - back, (n - back,)), 1e-3 * n
        one = straight.block([sample], arrival_s)
        other = torn.block([sample, again] if beside else [sample], arrival_s)
        if not beside:
            assert torn.block([again], arrival_s).times_s.size == 0
        assert other.times_s.tolist() == one.times_s.tolist()
        assert other.values.tolist() == [[n]]
    assert (torn.n_duplicates, torn.n_lost) == (len(repeats), 0)
    exact_case("samples that come twice", against="those that come once")


@pytest.mark.parametrize("lost_s", [0.03, 0.1, 5.0])
def test_stamps_after_a_gap_are_not_early(lost_s):
    """All samples are 50 ms late. After a gap, they have no delay."""
    samples = CountedSamples(1e-3, settling_s=0.0)
    for n in range(1000):
        samples.block([(n, n, (n,))], arrival_s=10.05 + n / 1000)
    lost = round(1000 * lost_s)
    first = 1000 + lost
    found = [samples.block([(n, n, (n,))], 10 + n / 1000) for n in range(first, first + 50)]
    stamps_s = np.concatenate([block.times_s for block in found])
    assert np.all(np.diff(stamps_s) > 0)
    goes_back = stamps_s[0] <= 10.05 + 0.999
    assert goes_back or stamps_s[0] - (10.05 + 0.999) > 0.02
    late_s = stamps_s - 10 - np.arange(first, first + 50) / 1000
    assert np.all(late_s[1:] > -1e-6)
    assert late_s[0] > (-0.02 if goes_back else -1e-6)


def test_restarted_device_may_count_from_any_number():
    samples = CountedSamples(1e-6, settling_s=0.0)
    samples.block([(500, 500_000, (1,))], 5.0)
    samples.may_begin_anew()
    assert samples.block([(3, 3_000, (2,)), (4, 4_000, (3,))], 5.6).times_s[-1] == pytest.approx(5.6, abs=1e-9)
    assert (samples.n_lost, samples.n_duplicates) == (0, 0)


def counted(samples, rate):
    for n in range(4500):
        samples.block([(n, round(1e3 * n * rate), (0,))], 1e-3 * n)


@pytest.mark.parametrize("rate", [10.0, 1.3, 1.03, 0.4, 0.0])
def test_device_with_wrong_clock_rate_is_refused(rate):
    message = rf"^line: found a clock that runs {rate:.3g} times as fast as this computer's, expected within 2%"
    with pytest.raises(DeviceFailed, match=message):
        counted(CountedSamples(1e-6, name="line"), rate)


@pytest.mark.parametrize("rate", [1.01, 1.0, 0.99])
def test_clock_within_one_percent_is_accepted(rate):
    counted(CountedSamples(1e-6, name="line"), rate)


def test_late_samples_at_start_change_no_clock_offset():
    clocks = ClockMap()
    for n in range(8000):
        clocks = clocks.after(1e-3 * n, max(1e-3 * n, 3.0))
        clocks.check("line")
    assert clocks.offset_s == 0.0


@pytest.mark.parametrize(("begin_s", "lag"), [(20.0, 0.45), (0.2, 0.49)], ids=["in between", "as it opens"])
@pytest.mark.parametrize("drift", [-1e-3, 0.0, 1e-3])
def test_gradually_caught_up_samples_are_accepted(begin_s, lag, drift):
    """A busy computer reads the waiting samples at 1.2 times the rate."""
    clocks, rate = ClockMap(), 1 + drift
    for n in range(4000):
        taken_s = 0.01 * n
        late_s = max(0.0, min(lag * (taken_s - begin_s), 3 * lag - 0.2 * (taken_s - begin_s - 3)))
        clocks = clocks.after(rate * taken_s, taken_s + late_s)
        clocks.check("line")


def test_clock_that_becomes_fast_is_detected():
    clocks = ClockMap()
    for n in range(7200):
        clocks = clocks.after(0.5 * n * (1 - 1e-4), 0.5 * n)
        clocks.check("line")
    for n in range(12):
        clocks = clocks.after(3600 * (1 - 1e-4) + 0.5 * n * 1.3, 3600 + 0.5 * n)
    with pytest.raises(DeviceFailed, match=r"runs 1\.3 times as fast"):
        clocks.check("line")


BLOCK_S = 0.01
steady = st.lists(st.floats(0.0, LATE_S * 0.99), min_size=2, max_size=80)


@given(steady, st.floats(-1e4, 1e4))
def test_stamps_consistent_with_arrival_are_accepted(delays_s, begin_s):
    arrivals = Arrivals()
    for n, delay_s in enumerate(delays_s):
        arrivals = arrivals.after(np.array([begin_s + 0.01 * n]), begin_s + 0.01 * n + delay_s)
        assert arrivals.fault is None
    assert arrivals.n_steps_back == 0


def first_fault(rate, delay_s=0.0):
    """Return when and why stamps of such a clock are first rejected (s)."""
    arrivals = Arrivals()
    for n in range(10_000):
        arrivals = arrivals.after(np.array([BLOCK_S * n * rate]), BLOCK_S * n + delay_s)
        if arrivals.fault is not None:
            return BLOCK_S * n, arrivals.fault
    pytest.fail("they are believed")


@given(st.floats(1.05, 100.0), st.floats(0.0, 0.05))
def test_fast_stamps_are_rejected_beyond_a_bound(rate, delay_s):
    at_s, fault = first_fault(rate, delay_s)
    assert (at_s - BLOCK_S) * (rate - 1) <= AHEAD_S + delay_s + 1e-9
    assert "after its arrival, expected none later than that: its clock runs fast" in fault


@given(st.floats(0.0, 0.95))
def test_slow_stamps_are_rejected_after_a_delay(rate):
    at_s, fault = first_fault(rate)
    assert at_s == pytest.approx(LATE_S / (1 - rate) + LATE_FOR_S, abs=2.1 * BLOCK_S)
    assert "s old on arrival, expected at most 0.1 s: its clock runs slow, has stopped" in fault


def test_delayed_block_is_not_a_slow_clock():
    """A second of samples arrives together. The next ones are current."""
    arrivals = Arrivals().after(np.arange(0.0, 1.0, 1e-3), 1.5)
    assert arrivals.late_since_s == 1.5
    arrivals = arrivals.after(np.array([1.5]), 1.51)
    assert (arrivals.late_since_s, arrivals.fault) == (None, None)


@pytest.mark.parametrize("stamp_s", [math.nan, math.inf, -math.inf])
def test_arrivals_reject_stamps_that_are_not_finite(stamp_s):
    assert Arrivals().after(np.array([1.0, stamp_s]), 1.0).fault.startswith("found a stamp that is not finite")


def test_steps_back_count_within_and_between_blocks():
    arrivals = Arrivals().after(np.array([1.0, 0.99, 1.01]), 1.02).after(np.array([1.0]), 1.02)
    assert arrivals.n_steps_back == 2


class Shifted:
    """Source of blocks of one sample, each with a stamp shifted by `off_s`."""

    name, n_channels, rate_hz = "shifted", 1, 100.0

    def __init__(self, off_s):
        self._off_s = iter(off_s)
        self.n_opened = 0

    def open(self):
        self.n_opened += 1

    def receive(self):
        time.sleep(2e-3)
        off_s = next(self._off_s, None)
        return None if off_s is None else SampleBlock(np.array([time.perf_counter() + off_s]), np.array([[off_s]]))

    def close(self):
        pass

    def facts(self):
        return {}


def test_reader_drops_only_blocks_with_rejected_stamps():
    """The source stays open, and its listeners receive empty blocks."""
    source, n_silent = Shifted([0.0, 0.0, 5.0, 6.0, 0.0, math.nan, 0.0]), []
    reader = Reader(source)
    listener = reader.listen()
    reader.subscribe(lambda block: n_silent.append(block.times_s.size == 0))
    reader.open()
    while len(n_silent) < 10:
        time.sleep(1e-3)
    reader.close()
    assert listener.read().values.tolist() == [[0.0]] * 4
    assert n_silent[:7] == [False, False, True, True, False, True, False]
    facts = reader.facts()
    assert (facts["n_samples"], facts["n_outages"], facts["failure"], source.n_opened) == (4, 2, None, 1)


class HalfOpen(Source):
    def __init__(self):
        super().__init__("half", rate_hz=100.0, n_channels=1)
        self.n_let_go = 0

    def open(self):
        self._opened.callback(self.let_go)
        raise OSError(2, "No such device")

    def let_go(self):
        self.n_let_go += 1

    def receive(self):
        raise AssertionError


def test_partly_opened_source_is_released():
    """Otherwise each attempt to reopen it would block one more of its parts."""
    source = HalfOpen()
    with pytest.raises(DeviceFailed, match="half: found a failure .*No such device"):
        Reader(source).open()
    assert source.n_let_go == 1


def test_clock_offset_is_exact_when_readings_are_interrupted():
    pauses_s = iter([0.05, 0.05, 0.0, 0.05, 0.05])

    def theirs_s():
        read_s = time.perf_counter() - 100.0
        time.sleep(next(pauses_s))
        return read_s

    assert clock_offset_s(theirs_s) == pytest.approx(100.0, abs=0.01)
