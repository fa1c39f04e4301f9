"""A session in a real window with a sensor and a simulated participant."""

import time
import tomllib
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

import numpy as np
from emulated import Emulator
from patience import LONGEST_WAIT_S
from seen import see
from window_sitting import tactometry

from tactometry.questionnaire import load

BENCH = """\
[screen]
fullscreen = false
language = "{language}"
dry_run = {dry_run}
[sensors.hand]
rate_hz = 1000
{sensor}
[force]
sensor = "hand"
channel = 2
newtons_per_count = 0.01
[position]
sensor = "hand"
channels = [0]
metres_per_count = 1e-6
"""
SENSORS = {
    "udp": 'kind = "udp"\naddress = "127.0.0.1"\nport = {0.udp_port}',
    "lsl": 'kind = "lsl"\nstream = "{0.name}"\nn_channels = 3',
    "serial": 'kind = "serial"\nport = "{0.port}"\nn_channels = 3',
}


class Sitting:
    """A folder with the text of a study and a bench, and a participant; `run` starts a session."""

    def __init__(self, folder, study, language, hands, sensor, *, dry_run):
        self.dry_run = dry_run
        self.folder, self.data = folder, folder / "data"
        self._hands, self._sensor = hands, sensor
        self.study = folder / "s.toml"
        self.study.write_text(study, encoding="utf-8")
        device = SENSORS[sensor.kind].format(sensor)
        bench = BENCH.format(language=language, dry_run=str(dry_run).lower(), sensor=device)
        (folder / "bench.toml").write_text(bench, encoding="utf-8")

    def run(self, *more):
        self._hands.cover()
        words = ("run", self.study, "--participant", "P01", "--seed", 3, "--bench", self.folder / "bench.toml")
        return tactometry(*words, "--out", self.data, *more)

    def finger(self, rng):
        return Finger(self._hands, rng, self._sensor)


@contextmanager
def sitting(folder, study, language, hands, kind="udp", *, dry_run=True):
    """Return a participant whose finger is at a sensor of a kind."""
    sensor = Emulator(kind, folder, options=("--steered",))
    try:
        yield Sitting(folder, study, language, hands, sensor, dry_run=dry_run)
    finally:
        sensor.close()
        hands.uncover()


def asked_to_end(process, finger):
    try:
        finger.sit(process)
        return process.returncode, *process.communicate(timeout=30)
    finally:
        with suppress(ProcessLookupError):
            process.kill()


def forms_of(study):
    table = tomllib.loads(study)
    names = [table["task"].get("form"), *(each["form"] for each in table.get("inquiries", {}).values())]
    return [load(name) for name in names if name]


def recorded_as(said, study):
    """Return the expected recorded numbers of a finger's answers."""
    first = 0 if '"yes_no"' in study else 1
    scales = {form.steps: form for form in forms_of(study)}

    def number(answer):
        match answer.kind:
            case "form":
                form = scales[answer.n]
                return form.low + answer.value * (form.high - form.low) / (answer.n - 1)
            case "question":
                return answer.value + first
            case _:
                return answer.value

    return [float(number(answer)) for answer in said]


LOOK_EVERY_S = 0.02
PATIENCE_S = 20.0
"""Time after which it repeats an action if the page has not changed."""
FIRST_COUNTS, MOST_COUNTS = 20.0, 900.0
LET_GO_PX = 8
STUCK_S = 3.0
DOT_UM_PER_S, TRACK_UM = 50e3, 100e3
"""Movement of the dot in the built-in studies: 50 mm/s along 0.1 m."""
DIGITS = "0123456789"


@dataclass(frozen=True)
class Said:
    """An answer: `kind` of page, and which of `n` places or choices from the left (or the number that was typed)."""

    kind: str
    value: int
    n: int = 0


@dataclass
class Pursuit:
    """When the dot of a track was last at its left end, from where it was seen."""

    since_s: float | None = None
    _seen: list = field(default_factory=list)

    def see(self, along, now_s):
        self._seen = [*self._seen[-1:], (along, now_s)]
        if len(self._seen) == 2 and 0.05 < along < 0.95 and along != self._seen[0][0]:
            rising = along > self._seen[0][0]
            self.since_s = now_s - (along if rising else 2 - along) * TRACK_UM / DOT_UM_PER_S

    def forget(self):
        self.since_s, self._seen = None, []


class Finger:
    """A participant at one display, whose answers a generator draws; `sensor` is a steered emulator or None."""

    def __init__(self, hands, rng, sensor=None):
        self._hands, self._rng, self._sensor = hands, rng, sensor
        self.said = []
        self.kinds = []
        """Pages in the order in which they were seen."""
        self.seen, self.picture, self.steady = None, None, False
        """Last view of the screen; steady if equal to the one before."""
        self._acted_on = None
        self._acted_s = 0.0
        self._counts, self._played, self._letting_go, self._held_since_s = 0.0, False, False, None
        self._pursuit, self._by_pointer, self._confirms = Pursuit(), False, False

    def sit(self, process, until=lambda finger: False):
        """Take part until the process ends, or, before it acts, something is seen: whether it was."""
        end_s = time.perf_counter() + LONGEST_WAIT_S
        while process.poll() is None:
            assert time.perf_counter() < end_s, f"a page that does not go on: {self.seen}, after {self.kinds}"
            now_s = time.perf_counter()
            if self._look(now_s):
                end_s = now_s + LONGEST_WAIT_S
                if until(self):
                    return True
                self._react(now_s)
            time.sleep(LOOK_EVERY_S)
        return False

    def _look(self, now_s):
        picture = self._hands.sees()
        self.steady = self.picture is not None and np.array_equal(picture, self.picture)
        self.picture = picture
        done = self._acted_on is not None and np.array_equal(picture, self._acted_on)
        if self.steady and done and now_s < self._acted_s + PATIENCE_S:
            return False
        self.seen = see(picture)
        return True

    def _react(self, now_s):
        if self.seen.kind == "touch":
            self._note("touch")
            self._acted_on = None
            self._touch(self.seen, now_s)
            return
        self._lift()
        if self.steady and self.seen.kind != "nothing" and self._act(self.seen):
            self._acted_on, self._acted_s = self.picture, time.perf_counter()

    def _note(self, kind):
        if not self.kinds or self.kinds[-1] != kind or self._acted_on is not None:
            self.kinds.append(kind)

    # --- touches

    def _steer(self, counts):
        self._counts = min(max(counts, 0.0), MOST_COUNTS)
        if self._sensor is None:
            return
        if self._pursuit.since_s is None:
            self._sensor.steer(self._counts)
        else:
            self._sensor.steer(self._counts, DOT_UM_PER_S, TRACK_UM, self._pursuit.since_s)

    def _lift(self):
        self._played, self._letting_go, self._held_since_s = False, False, None
        self._pursuit.forget()
        if self._counts:
            self._steer(0.0)

    def _touch(self, seen, now_s):
        if seen.dot_px is not None:
            length_px = seen.height_px * TRACK_UM / 0.3e6
            self._pursuit.see((seen.dot_px - self.picture.shape[1] / 2) / length_px + 0.5, now_s)
        if seen.bar is None:
            return
        self._letting_go |= self._played and seen.marker == "ready"
        self._played = seen.marker == "playing"
        if not seen.bar.held or self._played:
            self._held_since_s = now_s
        self._letting_go |= self._held_since_s is not None and now_s > self._held_since_s + STUCK_S
        if self._letting_go:
            self._letting_go = seen.bar.height > LET_GO_PX
            self._held_since_s = None
            self._steer(0.0)
        elif seen.bar.height <= LET_GO_PX:
            self._steer(max(FIRST_COUNTS, 1.2 * self._counts))
        else:
            wanted = min(max(seen.bar.wanted / seen.bar.height, 0.5), 2.0)
            self._steer(self._counts * (1 + 0.3 * (wanted - 1)))

    # --- pages

    def _act(self, seen):
        act = {"words": self._go_on, "question": self._choose, "form": self._fill, "number": self._enter}
        return act.get(seen.kind, self._confirm)(seen)

    def _go_on(self, seen):
        if not seen.asks:
            return False
        self._note("words")
        self._hands.tap("space")
        return True

    def _choose(self, seen):
        self._note("question")
        choice = int(self._rng.integers(len(seen.choices)))
        self.said.append(Said("question", choice, len(seen.choices)))
        self._click(seen.choices[choice])
        return True

    def _fill(self, seen):
        """Mark one more row; leave the page when each row has a mark."""
        open_rows = [k for k, mark in enumerate(seen.marked) if mark is None]
        if len(open_rows) == len(seen.rows):
            self._note("form")
            self._by_pointer = self._rng.random() < 0.5
        if not open_rows:
            self.said += [Said("form", mark, len(row)) for mark, row in zip(seen.marked, seen.rows, strict=True)]
            self._hands.tap("Return")
            return True
        row = seen.rows[open_rows[0]]
        place = int(self._rng.integers(len(row)))
        if self._by_pointer or len(row) >= len(DIGITS):
            self._click(row[place])
        else:
            self._hands.tap(DIGITS[place + 1])
        return True

    def _enter(self, seen):
        """Type a number, and press Return once it is visible.

        A busy machine may show it for a while after that, and a page with another number would look like a new one.
        """
        if seen.typed:
            return self._confirm_number()
        self._note("number")
        number = int(self._rng.integers(1, 100))
        self.said.append(Said("number", number))
        for digit in str(number):
            self._hands.tap(digit)
        self._confirms = True
        return True

    def _confirm_number(self):
        if self._confirms:
            self._hands.tap("Return")
        acted, self._confirms = self._confirms, False
        return acted

    def _confirm(self, seen):
        del seen
        self._note("adjust")
        self._hands.tap("Return")
        return True

    def _click(self, body):
        self._hands.click(*(round(place) for place in body.middle))
