"""Serial frames, counters, clocks, calibrations and speed."""

import math
import zlib
from itertools import pairwise

import numpy as np
import pytest
from emulator import encode_frame
from examples import examples
from hard_cases import exact_case, hard_case
from hypothesis import given, strategies as st

from tactometry.devices.clock_map import ClockMap
from tactometry.devices.sensors.counted_samples import SLEW, STEP_S, CountedSamples
from tactometry.devices.sensors.serial_line import Frame, Framing, frame_bytes
from tactometry.devices.sensors.streamed import ForceCalibration, mean_speed_m_per_s
from tactometry.devices.sensors.udp import RECORD, records
from tactometry.errors import InvalidParameter

REMEMBERED_S = 4.0
words = st.integers(0, 2**32 - 1)
frames = st.builds(Frame, words, words, st.tuples(*[st.integers(-(2**31), 2**31 - 1)] * 2))
noise = st.binary(max_size=30) | st.binary(max_size=4).map(lambda tail: b"\xa5\x5a\x02\x00" + tail)


def parsed(pieces):
    framing, found = Framing(n_channels=2), []
    for piece in pieces:
        framing, more = framing.after(piece)
        found += more
    return framing, found


@given(st.lists(st.tuples(noise, frames), max_size=8), st.lists(st.integers(0, 400), max_size=12))
def test_all_frames_are_found_between_noise(sent, cuts):
    stream = b"".join(before + encode_frame(frame) for before, frame in sent)
    edges = sorted({0, len(stream), *(cut for cut in cuts if cut < len(stream))})
    framing, found = parsed([stream[a:b] for a, b in pairwise(edges)])
    assert found == [frame for _, frame in sent]
    assert framing.n_skipped + len(framing.rest) == len(stream) - frame_bytes(2) * len(found)
    exact_case("frames torn anywhere, noise between", against="every whole frame")


@given(st.lists(frames, min_size=3, max_size=8), st.data())
def test_lost_byte_loses_one_frame_only(sent, data):
    torn = data.draw(st.integers(0, len(sent) - 1))
    where = data.draw(st.integers(0, frame_bytes(2) - 1))
    bytes_of = [encode_frame(frame) for frame in sent]
    bytes_of[torn] = bytes_of[torn][:where] + bytes_of[torn][where + 1 :]
    _, found = parsed([b"".join(bytes_of), bytes(frame_bytes(2))])
    assert found == [frame for n, frame in enumerate(sent) if n != torn]
    exact_case("a frame that lost a byte", against="all others")


@given(st.binary(max_size=3000))
def test_noise_contains_no_frame(garbage):
    framing, found = parsed([garbage])
    assert found == []
    assert framing.n_skipped + len(framing.rest) == len(garbage)
    assert len(framing.rest) < frame_bytes(2)


def test_frame_with_wrong_channel_count_is_skipped():
    sent = Frame(1, 2, (3, 4))
    body = bytearray(encode_frame(sent)[:-4])
    body[2] = 7
    assert parsed([body + zlib.crc32(body).to_bytes(4, "little"), encode_frame(sent)])[1] == [sent]


@given(st.binary(max_size=80).filter(lambda data: len(data) % RECORD.size))
def test_datagram_of_another_length_has_no_records(datagram):
    assert records(datagram) == []


# --- counters and clocks


def test_lost_samples_are_counted_across_the_wrap():
    samples = CountedSamples(1e-6, settling_s=0.0)
    block = samples.block([(2**32 - 2, 2**32 - 1000, (1,)), (1, 2000, (2,))], 5.0)
    assert samples.n_lost == 2
    assert np.diff(block.times_s) == pytest.approx(3e-3, abs=1e-9)


def test_restarted_device_loses_no_samples():
    samples = CountedSamples(1e-6, settling_s=0.0)
    samples.block([(5000, 9_000_000, (1,))], 5.0)
    block = samples.block([(0, 0, (1,))], 6.0)
    assert samples.n_lost == 0
    assert block.times_s[-1] == pytest.approx(6.0, abs=1e-9)


@given(st.integers(0, 2**32 - 1), st.floats(1e-5, 0.01), st.lists(st.tuples(st.integers(0, 999), st.floats(0, 2))))
@examples(50)
def test_stamps_follow_device_time_except_at_steps(seed, late_s, stalls):
    arrivals_s = np.arange(1000) * 2e-3 + np.random.default_rng(seed).exponential(late_s, 1000)
    for first, stall_s in stalls:
        arrivals_s[first] += stall_s
    arrivals_s = np.maximum.accumulate(arrivals_s)
    samples, times_s, came_s = CountedSamples(1e-6), [], []
    for n, arrival_s in enumerate(arrivals_s.tolist()):
        block = samples.block([(n, 2000 * n, (0,))], arrival_s)
        times_s += block.times_s.tolist()
        came_s += [arrival_s] * block.times_s.size
    steps_s = np.diff(times_s)
    followed = np.isclose(steps_s, 2e-3, rtol=1.01e-3)
    assert np.all(followed | (steps_s < 0) | (steps_s > STEP_S))
    assert np.all(np.array(times_s) <= np.array(came_s) + STEP_S + 1e-9)


def test_late_first_stamps_are_corrected():
    """Samples of the first second are 1.4 s late, as by a clock offset."""
    samples, late_s = CountedSamples(1e-3), []
    for n in range(2000):
        block = samples.block([(n, n, (0,))], 1e-3 * n + (1.4 if n < 1000 else 0.0))
        late_s += (block.times_s - 1e-3 * n).tolist()
    assert late_s[:400] == pytest.approx([1.4] * 400, abs=1e-9)
    assert late_s[-1000:] == pytest.approx([0.0] * 1000, abs=2e-3)


def test_step_back_in_a_gap_remains_visible():
    """After a gap of 30 ms, late stamps step back, so that a gate restarts."""
    samples = CountedSamples(1e-3, settling_s=0.0)
    first_s = samples.block([(0, 0, (0,))], 0.025).times_s
    assert samples.block([(1, 30, (0,))], 0.030).times_s < first_s


@given(st.lists(st.floats(0, 0.05), min_size=20, max_size=200), st.floats(-1e4, 1e4))
def test_stamps_are_between_sampling_and_arrival(delays_s, offset_s):
    clocks = ClockMap()
    for n, delay_s in enumerate(delays_s):
        device_s = n * 0.01
        clocks = clocks.after(device_s, device_s + offset_s + delay_s)
        assert clocks.ours_s(device_s) <= device_s + offset_s + delay_s + 1e-9
        assert clocks.ours_s(device_s) >= device_s + offset_s - 1e-9


@pytest.mark.parametrize("drift", [-1e-4, 0.0, 1e-4])
def test_clock_map_follows_a_drifting_clock(drift):
    clocks = ClockMap()
    for n in range(20_000):
        clocks = clocks.after(n * 1e-3, n * 1e-3 * (1 + drift) + 7.0)
    bound = (abs(drift) * REMEMBERED_S + 1e-9) / 27.0
    hard_case("a clock that drifts by 1e-4", clocks.ours_s(20.0), 20.0 * (1 + drift) + 7.0, bound, against="the drift")


def test_simultaneous_samples_settle_no_clock():
    samples = CountedSamples(1e-3)
    samples.block([(0, 0, (0,))], 100.0)
    assert samples.block([(n, n, (0,)) for n in range(1, 1001)], 100.5).times_s.size == 0


def test_stamps_stretch_by_at_most_slew():
    """A delay that grows by 10 ms shows once earlier samples are forgotten."""
    samples, times_s = CountedSamples(1e-3), []
    for n in range(8000):
        times_s += samples.block([(n, n, (0,))], 1e-3 * n + (0.0 if n < 1000 else 0.01)).times_s.tolist()
    steps_s = np.diff(times_s)
    assert np.all(steps_s <= 1e-3 * (1 + SLEW) + 1e-9)
    assert np.any(steps_s > 1e-3 * (1 + 0.9 * SLEW))


def test_clock_map_refuses_times_that_are_not_finite():
    with pytest.raises(InvalidParameter, match="found times nan and 1.0, expected finite"):
        ClockMap().after(math.nan, 1.0)
    with pytest.raises(InvalidParameter, match="found times 1.0 and inf, expected finite"):
        ClockMap().after(1.0, math.inf)
    with pytest.raises(InvalidParameter, match="found no sample yet"):
        ClockMap().ours_s(1.0)


# --- calibrations


def test_calibration_forms_agree():
    counts = np.array([0.0, 50.0, 200.0])
    factor = ForceCalibration(newtons_per_count=0.02, zero_count=50.0).force_n(counts)
    polynomial = ForceCalibration(polynomial=(-1.0, 0.02)).force_n(counts)
    table = ForceCalibration(table_counts=(0.0, 200.0), table_forces_n=(-1.0, 3.0)).force_n(counts)
    assert np.allclose(factor, polynomial, rtol=1e-12)
    assert np.allclose(factor, table, rtol=1e-12)


def test_counts_outside_calibration_range_are_lost_samples():
    table = ForceCalibration(table_counts=(0.0, 200.0), table_forces_n=(0.0, 3.0))
    assert np.isnan(table.force_n(np.array([-1.0, 201.0]))).all()
    factor = ForceCalibration(newtons_per_count=0.1, count_low=-10.0, count_high=10.0)
    assert np.isnan(factor.force_n(np.array([-11.0, 10.5, np.nan]))).all()


@pytest.mark.parametrize("overload", [9.99999999e37, -1e30, 1.1e5])
def test_implausible_force_is_a_lost_sample(overload):
    calibration = ForceCalibration(newtons_per_count=0.001)
    assert calibration.force_n(np.array([1000.0, overload])).tolist() == pytest.approx([1.0, np.nan], nan_ok=True)


@pytest.mark.parametrize(
    ("form", "message"),
    [
        ({}, "found none, or more than one, of newtons_per_count, polynomial and table_counts"),
        ({"newtons_per_count": 1.0, "polynomial": (0.0, 1.0)}, "found none, or more than one, of"),
        ({"newtons_per_count": 0.0}, "newtons_per_count: found 0.0, expected a finite nonzero number"),
        ({"newtons_per_count": math.inf}, "newtons_per_count: found inf, expected a finite nonzero number"),
        ({"polynomial": (0.0, math.nan)}, "polynomial: found .*expected at least two finite numbers"),
        ({"table_counts": (1.0,), "table_forces_n": (1.0,)}, "found 1 counts and 1 table_forces_n"),
        ({"table_counts": (0.0, 1.0), "table_forces_n": (0.0, math.inf)}, "at least two, all finite"),
        ({"polynomial": (1.0,)}, "polynomial: found .*expected at least two"),
        ({"table_counts": (0.0, 1.0)}, "found 2 counts and 0 table_forces_n"),
        ({"table_counts": (1.0, 1.0), "table_forces_n": (0.0, 1.0)}, "found counts that do not increase"),
        (
            {"table_counts": (0.0, 1.0, 2.0), "table_forces_n": (0.0, 1.0, 0.5)},
            "forces that neither increase nor decrease",
        ),
        ({"table_counts": (0.0, 1.0), "table_forces_n": (1.0, 1.0)}, "forces that neither increase nor decrease"),
        ({"polynomial": (1.5, 0.0)}, "the same force for several counts from -inf to inf, expected a monotonic"),
        ({"polynomial": (0.0, 1.0, -0.01), "count_high": 60.0}, "the same force for several counts from -inf to 60"),
        ({"newtons_per_count": 1.0, "count_low": 2.0, "count_high": 2.0}, "count_low: found 2.0, expected below"),
    ],
)
def test_invalid_calibration_forms_are_refused(form, message):
    with pytest.raises(InvalidParameter, match=message):
        ForceCalibration(**form)


def test_calibration_needs_monotonicity_within_its_range_only():
    bent = ForceCalibration(polynomial=(0.0, 1.0, -0.01), count_low=0.0, count_high=50.0)
    assert bent.force_n(np.array([10.0, 50.0])).tolist() == [9.0, 25.0]
    falling = ForceCalibration(table_counts=(0.0, 10.0), table_forces_n=(2.0, 0.0))
    assert falling.force_n(np.array([2.5])).tolist() == [1.5]
    risen = ForceCalibration(polynomial=(0.0, 1.0, 0.01), count_low=-50.0)
    assert risen.force_n(np.array([-50.0, 0.0])).tolist() == [-25.0, 0.0]
    assert ForceCalibration(polynomial=(0.0, 1.0, 0.0, 1.0)).force_n(np.array([2.0])).tolist() == [10.0]
    assert ForceCalibration(newtons_per_count=-0.5).force_n(np.array([-4.0])).tolist() == [2.0]


# --- speed


def test_mean_speed_counts_both_directions():
    times_s = np.arange(4000) / 1000
    positions_m = np.abs((times_s * 0.05 + 0.05) % 0.2 - 0.1)[:, None]
    assert mean_speed_m_per_s(times_s, positions_m) == pytest.approx(0.05, rel=0.01)


def test_mean_speed_of_resting_finger_is_small():
    at_rest_m = 2e-5 * np.random.default_rng(1).standard_normal((4000, 2))
    assert mean_speed_m_per_s(np.arange(4000) / 1000, at_rest_m) < 1e-3


def test_mean_speed_needs_two_positions():
    assert mean_speed_m_per_s(np.empty(0), np.empty((0, 2))) is None
    assert mean_speed_m_per_s(np.zeros(1), np.zeros((1, 2))) is None
    with pytest.raises(InvalidParameter, match="found .* stamps and .* positions"):
        mean_speed_m_per_s(np.array([1.0, 0.0]), np.zeros((2, 2)))


def test_samples_read_after_a_suspension_get_no_stamps():
    samples, stamps_s = CountedSamples(tick_s=1e-3), []
    for n in range(0, 6000, 100):
        arrival_s = max(0.001 * (n + 100), 2.0 + 0.00001 * n)
        block = samples.block([(k, k, (k,)) for k in range(n, n + 100)], arrival_s)
        stamps_s += [(time_s, 0.001 * value) for time_s, [value] in zip(block.times_s, block.values, strict=True)]
    late_s = np.array([stamp_s - taken_s for stamp_s, taken_s in stamps_s])
    assert 3000 < len(late_s) < 4500
    assert np.all(late_s >= -1e-9)
    assert np.all(late_s < 0.02)
