"""A force sensor process of 1 kHz.

`python emulator.py serial FD | udp PORT | lsl NAME`.

Its clock may run `--clock` times as fast as ours, from `--ahead` s on.

Channel 0 counts the samples; channel 1 is the time at which each was taken, in microseconds of the clock that all
processes of a machine share, modulo 2**31; channel 2 is the force in counts. `--profile` is a repeated list of
seconds:counts, in which a count of - is a gap without samples.

With `--steered` a hand is at the sensor. A line `COUNTS SPEED LENGTH SINCE` of the input sets its target force, and the
path on which it moves to and fro from a moment on (um/s, um, s; a speed of 0 is a hand at rest). Channel 0 is then its
place in um.

The network sensor sends from a request to begin until one to end, as often as it is asked.
"""

import argparse
import contextlib
import os
import select
import socket
import struct
import sys
import time
import zlib

from tactometry.devices.sensors.serial_line import SYNC, Frame
from tactometry.devices.sensors.udp import BEGIN, END, RECORD

RATE_HZ = 1000.0


def samples(asked):
    """Yield (n, time stamp in s, values) when due.

    A late sample keeps the time at which it was due.
    """
    begin_s, n_due, n, profile = time.perf_counter(), 0, 0, asked.profile
    hand = Hand() if asked.steered else None
    while True:
        due_s = begin_s + n_due / RATE_HZ
        time.sleep(max(0.0, due_s - time.perf_counter()))
        force = counts_at(profile, n_due / RATE_HZ)
        n_due += 1
        if hand is not None:
            hand.move()
            yield n, due_s, (round(hand.place_um), round(due_s * 1e6) % 2**31, round(hand.counts))
            n += 1
        elif force is not None:
            stamp_s = begin_s + asked.clock * (due_s - begin_s) + asked.ahead
            yield n, stamp_s, (n, round(due_s * 1e6) % 2**31, force)
            n += 1


class Hand:
    """A finger that follows requests for force and dot within `TAU_S`."""

    TAU_S, CATCH_UP_PER_S, FASTER = 0.03, 2.0, 0.25

    def __init__(self):
        self.counts = self.place_um = self._speed = 0.0
        self._wanted, self._heard = (0.0, 0.0, 1.0, 0.0), b""
        os.set_blocking(sys.stdin.fileno(), False)

    def move(self):
        with contextlib.suppress(BlockingIOError):
            *lines, self._heard = (self._heard + os.read(sys.stdin.fileno(), 4096)).split(b"\n")
            for line in lines:
                self._wanted = tuple(float(number) for number in line.split())
        part = 1 / (RATE_HZ * self.TAU_S)
        self.counts += part * (self._wanted[0] - self.counts)
        self._speed += part * (self._pursuit() - self._speed)
        self.place_um += self._speed / RATE_HZ

    def _pursuit(self):
        """Return the dot's speed, corrected for the distance to the dot."""
        _, speed, length, since_s = self._wanted
        along = speed * (time.perf_counter() - since_s) % (2 * length)
        place, way = (along, speed) if along < length else (2 * length - along, -speed)
        catch_up = self.CATCH_UP_PER_S * (place - self.place_um)
        return way + min(max(catch_up, -self.FASTER * speed), self.FASTER * speed)


def counts_at(profile, time_s):
    """Return the counts of a profile of (duration in s, counts or None)."""
    left_s = time_s % sum(duration_s for duration_s, _ in profile)
    for duration_s, counts in profile:
        if left_s < duration_s:
            return counts
        left_s -= duration_s
    return profile[-1][1]


def profile_of(text):
    parts = [part.split(":") for part in text.split(",")]
    return [(float(duration_s), None if counts == "-" else int(counts)) for duration_s, counts in parts]


def encode_frame(frame):
    """Encode a sample as in `tactometry.devices.sensors.serial_line`."""
    n = len(frame.values)
    body = struct.pack(f"<2sBBII{n}i", SYNC, n, 0, frame.counter % 2**32, frame.time_us % 2**32, *frame.values)
    return body + struct.pack("<I", zlib.crc32(body))


def run_serial(asked):
    """Run a board that begins when its line is opened, as many do."""
    line = select.poll()
    line.register(int(asked.target), 0)
    while line.poll(0):
        time.sleep(0.01)
    for n, stamp_s, values in samples(asked):
        os.write(int(asked.target), encode_frame(Frame(n, round(stamp_s * 1e6) % 2**32, values)))


def run_udp(asked):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", int(asked.target)))
        print("ready", flush=True)
        request, address = line.recvfrom(64)
        assert request == BEGIN
        line.setblocking(False)
        for n, _, values in samples(asked):
            record = RECORD.pack(n % 2**32, round(7 * asked.clock * n) % 2**32, 0, *values, 0, 0, 0)
            if address:
                line.sendto(record, address)
            if n % 100 == 0:
                address = asker(line, address)


def asker(line, address):
    with contextlib.suppress(BlockingIOError):
        while True:
            request, origin = line.recvfrom(64)
            assert request in (BEGIN, END)
            address = origin if request == BEGIN else None
    return address


def run_lsl(asked):
    import pylsl

    info = pylsl.StreamInfo(asked.target, "Force", 3, RATE_HZ, pylsl.cf_double64, asked.source_id or asked.target)
    outlet = pylsl.StreamOutlet(info)
    offset_s = pylsl.local_clock() - time.perf_counter()
    print("ready", flush=True)
    outlet.wait_for_consumers(30)
    for _, stamp_s, values in samples(asked):
        outlet.push_sample(list(map(float, values)), stamp_s + offset_s)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("kind", choices=["serial", "udp", "lsl"])
    parser.add_argument("target")
    parser.add_argument("--profile", type=profile_of, default=profile_of("1:100"))
    parser.add_argument("--clock", type=float, default=1.0)
    parser.add_argument("--ahead", type=float, default=0.0)
    parser.add_argument("--source-id", default="")
    parser.add_argument("--steered", action="store_true")
    asked = parser.parse_args()
    try:
        {"serial": run_serial, "udp": run_udp, "lsl": run_lsl}[asked.kind](asked)
    except (BrokenPipeError, OSError) as gone:
        sys.exit(str(gone))
