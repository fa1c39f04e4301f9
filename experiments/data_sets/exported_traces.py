"""Export of traces: BIDS `physio` and `motion`, and tables for Psych-DS.

A BIDS file has one sampling rate, and the pauses between touches would make files of emitted signals too large. Emitted
signals are therefore copied unchanged, with a table of where each touch begins.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np

from tactometry import __version__
from tactometry.files.durable import read_file
from tactometry.files.rows import spreadsheet_text
from tactometry.records.data_set import sessions
from tactometry.records.journal import read
from tactometry.records.traces import MISSING, TraceDescription, decode_rows, kind_of, packed, read_text, sidecar_of
from tactometry.session.answer import TracePart
from tactometry.session.event import TraceKind
from tactometry.signal import FloatArray

from .source import json_text
from .traces import RecordedTouch, described, touches

Files = Iterator[tuple[str, bytes]]
NO_SAMPLE: Final = b"n/a\tn/a\n"
NOT_STATED: Final = (
    *("DeviceSerialNumber", "Manufacturer", "ManufacturersModelName", "Instructions", "SubjectArtefactDescription"),
    *("InstitutionName", "InstitutionAddress", "InstitutionalDepartmentName"),
)
"""Keys that BIDS recommends for motion, but that a journal does not contain."""
ABSENT: Final = ("ACCEL", "ANGACCEL", "GYRO", "JNTANG", "MAGN", "MISC", "ORNT", "VEL")
"""Channel types of BIDS that a touch does not have."""


@dataclass(frozen=True)
class TracedSession:
    """Touches of a session with samples of one kind, and their locations."""

    root: Path
    kind: TraceKind
    participant: str
    session: int
    study: str
    parts: tuple[tuple[RecordedTouch, TracePart], ...]

    @cached_property
    def description(self) -> TraceDescription:
        """Sampling rate and columns of the samples.

        Raises `InvalidFile` if the JSON file of the samples does not state them.
        """
        return described(self.root, [part for _, part in self.parts])

    def texts(self) -> Iterator[tuple[RecordedTouch, bytes]]:
        return ((touch, read_text(self.root, part)) for touch, part in self.parts)


def traces_as(form: str, path: Path, task: str, files: Mapping[str, bytes]) -> Files:
    """Yield the trace files of a data set, converted to an export format.

    A single trials file yields no files, nor does a form without traces. `files` are the other files of the export.
    """
    write = _FORMS.get(form)
    if write is None or not path.is_dir():
        return
    for journal in sessions(path):
        for traced in _traced(path, journal):
            yield from write(traced, task, files)


def _traced(root: Path, journal: Path) -> Iterator[TracedSession]:
    recording = read(journal)
    result: dict[TraceKind, list[tuple[RecordedTouch, TracePart]]] = {}
    for touch in touches(recording):
        for part in touch.answer.trace:
            kind = kind_of(part)
            if kind is not None:
                result.setdefault(kind, []).append((touch, part))
    for kind, parts in result.items():
        head = parts[0][0].head
        yield TracedSession(root, kind, head.participant, head.session, head.study, tuple(parts))


def _psychds(traced: TracedSession, task: str, files: Mapping[str, bytes]) -> Files:
    del task, files
    if traced.kind == "emitted":
        return
    lines = [spreadsheet_text([["trial", "attempt", *traced.description.names]])]
    for touch, text in traced.texts():
        whose = f"{touch.trial.trial},{touch.trial.attempt},".encode()
        rows = text.replace(b"\t", b",").replace(MISSING.encode(), b"").splitlines(keepends=True)
        lines += [whose + row for row in rows]
    study = traced.study.replace("-", "")
    stem = f"subject-{traced.participant}_session-{traced.session}_study-{study}_description-{traced.kind}"
    yield f"data/{stem}_data.csv", b"".join(lines)


def _bids(traced: TracedSession, task: str, files: Mapping[str, bytes]) -> Files:
    folder = f"sub-{traced.participant}/ses-{traced.session}"
    yield from _BIDS[traced.kind](traced, folder, task)
    if traced.kind == "position":  # BIDS requires motion events in the same folder
        events = {name: content for name, content in files.items() if name.startswith(folder) and "_events." in name}
        yield from ((name.replace("/beh/", "/motion/"), content) for name, content in events.items())


def _physio(traced: TracedSession, folder: str, task: str) -> Files:
    """Yield the force at a constant rate, as `physio` has no time stamps.

    Each row contains the nearest sample with its time stamp, or n/a between touches and for lost samples.
    """
    texts = [text for _, text in traced.texts()]
    times_s = np.concatenate([decode_rows(text)[:, 0] for text in texts])
    begin_s, rate_hz = float(times_s[0]), traced.description.rate_hz
    places = np.rint((times_s - begin_s) * rate_hz).astype(int)
    lines = [NO_SAMPLE] * (int(places.max()) + 1)
    for place, line in zip(places.tolist(), b"".join(texts).splitlines(keepends=True), strict=True):
        lines[place] = line
    stem = f"{folder}/beh/{_entities(folder)}_task-{task}_run-01_recording-force_physio"
    columns = {c.name: {"Description": c.description, "Units": c.unit} for c in traced.description.columns}
    timing = {"SamplingFrequency": rate_hz, "StartTime": begin_s, "Columns": list(columns)}
    sidecar = {"TaskName": task, "PhysioType": "generic", **timing, **columns}
    yield f"{stem}.tsv.gz", packed(b"".join(lines))
    yield f"{stem}.json", json_text(sidecar)


def _motion(traced: TracedSession, folder: str, task: str) -> Files:
    """Yield positions with their time stamps, which BIDS calls latencies."""
    stem = f"{folder}/motion/{_entities(folder)}_task-{task}_tracksys-finger_run-01"
    names = traced.description.names[1:]
    axes = [name.removesuffix("_m") for name in names]
    rows = [["time_s", MISSING, "LATENCY", MISSING, "s"]]
    rows += [[name, axis, "POS", "finger", "m"] for name, axis in zip(names, axes, strict=True)]
    header = ["name", "component", "type", "tracked_point", "units"]
    texts = [text for _, text in traced.texts()]
    yield f"{stem}_motion.tsv", b"".join(texts)
    yield f"{stem}_channels.tsv", spreadsheet_text([header, *rows], "\t")
    measured = effective_rate_hz([decode_rows(text)[:, 0] for text in texts])
    rates = {"SamplingFrequency": traced.description.rate_hz} | (
        {"SamplingFrequencyEffective": measured} if measured else {}
    )
    yield f"{stem}_motion.json", json_text({**_motion_sidecar(task, len(axes)), **rates})


def effective_rate_hz(stamps_s: Sequence[FloatArray]) -> float:
    """Return the samples per second in touches, or 0 for single samples.

    >>> effective_rate_hz([np.array([0.0, 0.1, 0.2]), np.array([5.0, 5.1])])
    10.0
    """
    spans_s = sum(float(times_s[-1] - times_s[0]) for times_s in stamps_s)
    return round(sum(times_s.size - 1 for times_s in stamps_s) / spans_s, 6) if spans_s > 0 else 0.0


def _motion_sidecar(task: str, n_axes: int) -> Mapping[str, object]:
    return {
        **dict.fromkeys(NOT_STATED, MISSING),
        **dict.fromkeys((f"{kind}ChannelCount" for kind in ABSENT), 0),
        "TaskName": task,
        "TrackingSystemName": "finger",
        "MotionChannelCount": n_axes + 1,
        "POSChannelCount": n_axes,
        "LATENCYChannelCount": 1,
        "TrackedPointsCount": 1,
        "MissingValues": MISSING,
        "SoftwareVersions": f"Tactometry {__version__}",
    }


def _stim(traced: TracedSession, folder: str, task: str) -> Files:
    del folder, task
    file = Path(traced.parts[0][1].file)
    header = ["onset", "first_byte", "n_bytes", "sampling_frequency"]
    rows = [
        [str(touch.answer.onset_s), str(part.first_byte), str(part.n_bytes), f"{part.rate_hz:.17g}"]
        for touch, part in traced.parts
    ]
    for name in (file, sidecar_of(file)):
        yield f"sourcedata/{name.as_posix()}", read_file(traced.root / name, "traces")
    yield f"sourcedata/{file.as_posix().removesuffix('.tsv.gz')}_touches.tsv", spreadsheet_text([header, *rows], "\t")


def _entities(folder: str) -> str:
    return folder.replace("/", "_")


_BIDS: Final[Mapping[TraceKind, Callable[[TracedSession, str, str], Files]]] = {
    "force": _physio,
    "position": _motion,
    "emitted": _stim,
}
_FORMS: Final[Mapping[str, Callable[[TracedSession, str, Mapping[str, bytes]], Files]]] = {
    "bids": _bids,
    "psych-ds": _psychds,
}
