"""A session in a real window with a sensor and a simulated participant."""

import os
import tomllib
from contextlib import contextmanager, suppress

from emulated import Emulator
from scripted_finger import Eye, Finger
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

    def __init__(self, folder, study, language, hands, eye, sensor, *, dry_run):
        self.dry_run = dry_run
        self.folder, self.data = folder, folder / "data"
        self._hands, self._eye, self._sensor = hands, eye, sensor
        self.study = folder / "s.toml"
        self.study.write_text(study, encoding="utf-8")
        device = SENSORS[sensor.kind].format(sensor)
        bench = BENCH.format(language=language, dry_run=str(dry_run).lower(), sensor=device)
        (folder / "bench.toml").write_text(bench, encoding="utf-8")

    def run(self, *more):
        self._eye.cover()
        words = ("run", self.study, "--participant", "P01", "--seed", 3, "--bench", self.folder / "bench.toml")
        return tactometry(*words, "--out", self.data, *more)

    def finger(self, rng):
        return Finger(self._hands, self._eye, rng, self._sensor)


@contextmanager
def sitting(folder, study, language, hands, kind="udp", *, dry_run=True):
    """Return a participant whose finger is at a sensor of a kind."""
    eye, sensor = Eye(os.environ["DISPLAY"]), Emulator(kind, folder, options=("--steered",))
    try:
        yield Sitting(folder, study, language, hands, eye, sensor, dry_run=dry_run)
    finally:
        sensor.close()
        eye.close()


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
