"""Recorded force, position and emitted signal of touches, with checks."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

from tactometry.arguments.require import expect
from tactometry.errors import InvalidFile, TactometryError, count_of
from tactometry.files.durable import read_file
from tactometry.provenance import versions
from tactometry.records.data_set import keys_of, sessions
from tactometry.records.head import Head
from tactometry.records.journal import Entry, Recording, read
from tactometry.records.traces import TraceDescription, kind_of, part_flaw, read_part, read_sidecar, sidecar_of
from tactometry.rigs.emitter import render
from tactometry.session.answer import Adjusted, Played, Touched, TracePart
from tactometry.session.request import Adjust, Play, Press, Record, Slide
from tactometry.signal import FloatArray, Signal, Stimulus
from tactometry.trials.row_rules import Defect
from tactometry.trials.trial import Trial

from ..bench.bench_file import load_bench
from ..bench.stimuli import bank_on
from ..study.experiment import wire
from ..study.study_file import parse

Felt = Played | Touched | Adjusted
Asked = Play | Press | Slide | Adjust
MOST_SAMPLES: Final = 2**26
"""Largest number of samples of a sensor in a session: 18 hours at 1 kHz (unverified default)."""
RAMP: Final = "ramp_s"
"""Key of a sitting's head for the ramp duration of its signals."""


class Samples(NamedTuple):
    """Time stamps (n_samples,) in s from the start of the session, and values.

    Values are forces (n_samples,) in N or positions (n_samples, n_axes) in m.
    """

    times_s: FloatArray
    values: FloatArray


@dataclass(frozen=True)
class TouchTrace:
    """One touch of a trial: request, result and recorded samples.

    - `head`: Head of the sitting (part of a session).
    - `trial`: First row of its trial.
    - `request`, `answer`: Request and result of the touch. Times are in s from the start of the session.
    - `force`, `position`: Samples recorded from the request on, for at most a minute.
    - `emitted`: Emitted signal from the onset on. None if nothing was emitted, or the signal cannot be recomputed.
    - `unknown`: Reason why the emitted signal cannot be recomputed.
    """

    head: Head
    trial: Trial
    request: Asked
    answer: Felt
    force: Samples | None
    position: Samples | None
    emitted: Signal | None
    unknown: str | None = None

    @property
    def played(self) -> bool:
        """True if the stimulus or the blank interval was presented."""
        return not isinstance(self.answer, Touched) or self.answer.played


def read_traces(
    path: Path,
    trial: int,
    *,
    participant: str | None = None,
    session: int | None = None,
    bench: Path | None = None,
) -> list[TouchTrace]:
    """Read the touches of all attempts at a trial, in order.

    An emitted signal that followed the finger is read from its file. Others are computed from the study, or None if the
    digest differs from that in the journal.

    Parameters
    ----------
    path : Path
        Folder of a data set, or one of its journals.
    trial : int
        Number of the trial in its session.
    participant, session
        Participant and session, if the data set has several.
    bench : Path, optional
        Bench file, needed if its learned responses or its board changed the signals of the study.

    Returns
    -------
    list of TouchTrace
        Empty if the trial had no touch.

    Raises
    ------
    InvalidFile
        If the journal or the traces are damaged, or not exactly one session matches.
    InvalidParameter
        If the session has no such trial.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from tactometry.experiments.sessions.recording import Who, record, simulated
    >>> from tactometry.experiments.study.study_file import load
    >>> study, study_toml = load("tutorial")
    >>> experiment, who = wire(study, "tutorial"), Who("P01", seed=1)
    >>> with TemporaryDirectory() as folder:
    ...     recorded = record(experiment, study_toml, Path(folder), who, simulated(experiment, who))
    ...     (touch,) = read_traces(Path(folder), 2)
    >>> touch.trial.level, touch.emitted, touch.force  # a simulated finger has no samples
    (38.0, Signal(1 channel x 10000 samples at 20000 Hz (0.5 s), peak 75.5447 V), None)
    """
    journal = _journal(path, participant, session)
    recording, root = read(journal), journal.parent.parent
    numbers = {row.trial for row in recording.trials}
    span = f"from {min(numbers)} to {max(numbers)}" if numbers else "which has no trials yet"
    expect(trial in numbers, "trial", trial, f"a trial of {journal.stem}, {span}")
    felt = [touch for touch in touches(recording) if touch.trial.trial == trial]
    bank = _bank(root, bench) if any(touch.digest for touch in felt) else {}
    return [_read(root, touch, bank) for touch in felt]


class RecordedTouch(NamedTuple):
    """Touch in a journal, with its session head and trial row."""

    head: Head
    request: Asked
    answer: Felt
    trial: Trial

    @property
    def digest(self) -> str | None:
        """Digest of the emitted signal, or None if there was not exactly one."""
        return None if isinstance(self.answer, Adjusted) else self.answer.digest or None


def touches(recording: Recording) -> Iterator[RecordedTouch]:
    """Yield the touches of a session whose trials have a row, in order.

    Each has the final row of its trial, in which a trial that was cancelled later is not valid.
    """
    head, felt = recording.head, list[tuple[Asked, Felt]]()
    rows = {row.key: row for row in reversed(recording.trials)}  # keeps the first row of each trial
    for line in recording.lines:
        match line:
            case Head():
                head = line
            case Entry(Play() | Press() | Slide() | Adjust() as request, answer):
                felt.append((request, answer))
            case Entry(Record(trial), _) if head is not None:
                yield from (RecordedTouch(head, request, answer, rows[trial.key]) for request, answer in felt)
                felt = []


def _journal(path: Path, participant: str | None, session: int | None) -> Path:
    """Return the only journal that matches participant and session."""
    if path.is_file():
        return path
    every = list(sessions(path))
    expect(bool(every), path, "no journal", "a data set with journals/*.jsonl, or a journal", InvalidFile)
    requested = {"participant": participant, "session": None if session is None else str(session)}
    given = {key: value for key, value in requested.items() if value is not None}
    meant = [journal for journal in every if given.items() <= keys_of(journal.stem).items()]
    if len(meant) != 1:
        found = f"{count_of(len(meant), 'session')}{' of ' if given else ''}{', '.join(given.values())}"
        raise InvalidFile(f"{path}: found {found}, expected one; state its participant and session")
    return meant[0]


def _bank(root: Path, bench: Path | None) -> Mapping[str, Stimulus]:
    """Return the stimuli of the recorded study, as the bench plays them."""
    path = root / "study.toml"
    study = parse(read_file(path, "the study that ran"), str(path))
    try:
        experiment = wire(study, str(path), begun=True)
    except TactometryError:  # files or code of the study are missing: their stimuli are not computed
        experiment = wire(study, str(path), plays=False)
    bank = experiment.bank if bench is None else bank_on(experiment, load_bench(bench))
    return {name: stimulus for name, stimulus in bank.items() if getattr(stimulus, "read", True)}


def _read(root: Path, touch: RecordedTouch, bank: Mapping[str, Stimulus]) -> TouchTrace:
    parts = {kind: part for part in touch.answer.trace if (kind := kind_of(part)) is not None}
    force, position = (_samples(root, parts.get(kind)) for kind in ("force", "position"))
    stored = parts.get("emitted")
    emitted = _computed(touch, bank) if stored is None else _stored(root, stored)
    along = None if force is None else Samples(force.times_s, force.values[:, 0])
    unknown = _unknown(touch) if touch.digest is not None and emitted is None else None
    return TouchTrace(touch.head, touch.trial, touch.request, touch.answer, along, position, emitted, unknown)


def _samples(root: Path, part: TracePart | None) -> Samples | None:
    if part is None:
        return None
    table = read_part(root, part)
    return Samples(table[:, 0], table[:, 1:])


def _stored(root: Path, part: TracePart) -> Signal:
    return Signal(read_part(root, part).T, part.rate_hz or 1.0, "V")


def _computed(touch: RecordedTouch, bank: Mapping[str, Stimulus]) -> Signal | None:
    """Compute the emitted signal of a stimulus, or None if its digest differs."""
    level = touch.request.level if isinstance(touch.request, Play | Press | Slide) else None
    if touch.digest is None or level is None or touch.request.stimulus not in bank:
        return None
    ramp_s = touch.head.facts.get(RAMP)
    signal = render(bank, touch.request.stimulus, level, None, ramp_s if isinstance(ramp_s, float) else 0.0)
    return signal if signal.digest() == touch.digest else None


def _unknown(touch: RecordedTouch) -> str:
    here = versions()
    others = [
        f"{name} {version} (here {here.get(name, 'none')})"
        for name, version in touch.head.versions.items()
        if here.get(name) != version
    ]
    recorded = f": {', '.join(others)}" if others else ""
    return (
        f"the study's signal differs from the recorded digest {touch.digest}. It was recorded by another version"
        f"{recorded}, or on a bench with learned responses or a board (state its file), or with a simulated finger "
        "on a texture, whose path is not stored"
    )


def trace_defects(root: Path, recording: Recording) -> Iterator[Defect]:
    """Yield defects for traces of a journal that are missing or changed."""
    parts: dict[str, list[TracePart]] = {}
    for line in recording.entries:
        for part in getattr(line.answer, "trace", ()):
            parts.setdefault(part.file, []).append(part)
    for name, of_file in parts.items():
        flaws = [flaw for part in of_file if (flaw := part_flaw(root, part)) is not None]
        yield from (Defect(name, None, flaw) for flaw in flaws)
        try:
            _ = None if flaws else described(root, of_file)
        except InvalidFile as error:
            beside = sidecar_of(Path(name))
            yield Defect(beside.as_posix(), None, str(error).removeprefix(f"{root / beside}: "))


def described(root: Path, parts: Sequence[TracePart]) -> TraceDescription:
    """Read the description of traces, and check it against their samples.

    Raises `InvalidFile` if the description is missing, damaged, or does not fit the samples.
    """
    beside = root / sidecar_of(Path(parts[0].file))
    description = read_sidecar(beside)
    first, last = read_part(root, parts[0]), read_part(root, parts[-1])
    one_each = f"a name for each of the {first.shape[1]} columns of the samples"
    expect(first.shape[1] == len(description.columns), f"{beside}: Columns", description.names, one_each, InvalidFile)
    if kind_of(parts[0]) != "emitted":
        n_samples = (last[-1, 0] - first[0, 0]) * description.rate_hz
        rate = f"the rate of the samples, at most {MOST_SAMPLES} in a session"
        expect(
            n_samples < MOST_SAMPLES, f"{beside}: SamplingFrequency", f"{description.rate_hz:g} Hz", rate, InvalidFile
        )
    return description
