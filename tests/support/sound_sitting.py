"""Sittings of a recorded study."""

from itertools import count

from tutorial_session import EXPERIMENT, TOML, WHO

from tactometry.experiments.sessions.recording import RigKind, record, simulated
from tactometry.session.request import Slide

SOUND = {"output": "audio x", "output_volts_per_unit": 200.0, "output_n_underruns": 3, "utc_minus_clock_s": 1.0}


def sit(root, facts, stops_at=None, *, resume=False, experiment=EXPERIMENT, toml=TOML, who=WHO, rig="bench"):
    told, make = [], simulated(experiment, who).make
    kind = RigKind(rig, lambda seed, log: Attended(make(seed, log), facts, stops_at))
    try:
        record(experiment, toml, root, who, kind, resume=resume, tell=told.append)
    except KeyboardInterrupt:
        return told
    assert stops_at is None
    return told


class Attended:
    """A rig with facts of a bench, whose session is interrupted at a request."""

    def __init__(self, rig, facts, stops_at):
        self._rig, self._facts, self._stops_at, self._n = rig, facts, stops_at, count(1)

    def facts(self):
        return self._facts

    def answer(self, request):
        if isinstance(request, Slide) and next(self._n) == self._stops_at:
            raise KeyboardInterrupt
        return self._rig.answer(request)

    def __getattr__(self, name):
        return getattr(self._rig, name)
