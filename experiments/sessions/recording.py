"""Record one session from start to end, or resume it, on any rig."""

import secrets
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from tactometry.errors import InvalidParameter
from tactometry.protocols.block_state import Track
from tactometry.provenance import sha256, versions
from tactometry.records.data_set import LARGEST_NUMBER, Session
from tactometry.records.description import SIMULATED, StudyDescription
from tactometry.records.erasures import Withdrawal, refuse_erased
from tactometry.records.head import Head, differences
from tactometry.records.open_session import OpenSession
from tactometry.session.event import EventLog
from tactometry.session.request import Fact, Rig
from tactometry.session.run import run
from tactometry.trials.trial import Tally

from ..study.experiment import Experiment
from ..study.rehearsal import flaw


@dataclass(frozen=True)
class Who:
    """Participant of a session. Seed None: drawn, or recorded before."""

    participant: str
    session: int = 1
    number: int | None = None
    seed: int | None = None

    @property
    def counterbalancing_number(self) -> int:
        """The given number, or else the trailing digits of the participant code.

        >>> Who("P017").counterbalancing_number
        17
        """
        digits = self.participant[len(self.participant.rstrip("0123456789")) :]
        number = int(digits) if self.number is None and digits else self.number
        if number is None or not 1 <= number <= LARGEST_NUMBER:
            upto = f" to {LARGEST_NUMBER}" if number is not None and number > 1 else ""
            raise InvalidParameter(
                f"participant {self.participant!r}: found no number from 1{upto} for counterbalancing, expected a code "
                "that ends with one, such as P01; or state --number"
            )
        return number


@dataclass(frozen=True)
class Recorded:
    """Result of a sitting, with numbers of trials overall and before it."""

    trials: Path
    tally: Tally
    n_resumed: int
    tracks: tuple[Track, ...]
    repaired: str | None

    @property
    def n_trials(self) -> int:
        return self.tally.n_trials

    @property
    def practice_missed(self) -> bool:
        """True if the practice ended and its criterion was not met."""
        return any(track.missed_practice for track in self.tracks)

    @property
    def endings(self) -> dict[str, int]:
        """Number of procedures for each ending."""
        endings = [track.ending for track in self.tracks]
        return {ending: endings.count(ending) for ending in dict.fromkeys(endings) if ending}


@dataclass(frozen=True)
class RigKind:
    """Factory of a rig, with the ground truth of a simulated participant.

    Rigs with `simulated_time` record no time stamps, so that the same seed gives the same bytes.
    """

    name: str
    make: Callable[[int, EventLog], Rig]
    observer: Callable[[int], dict[str, Fact]] = lambda seed: {}
    simulated_time: bool = False


def simulated(experiment: Experiment, who: Who) -> RigKind:
    """Return the kind of rig that simulates this participant."""
    return RigKind(
        "simulated",
        lambda seed, log: experiment.simulated_rig(who.participant, who.session, seed),
        lambda seed: experiment.simulated_person(who.participant, seed).facts(),
        simulated_time=True,
    )


def record(
    experiment: Experiment,
    study_toml: bytes,
    root: Path,
    who: Who,
    kind: RigKind,
    *,
    resume: bool = False,
    allow_erased: bool = False,
    tell: Callable[[str], None] = lambda sentence: None,
) -> Recorded:
    """Record a session, or its remaining part.

    `tell` receives messages for the experimenter before the session begins.

    Raises `InvalidFile` if the session is already recorded and `resume` is False, or `root` contains another study.
    Raises `InvalidParameter` if the seed or number differs from the recorded one, or the participant was erased without
    `allow_erased`.
    """
    design, session = experiment.design(study_toml), Session(who.participant, who.session, experiment.study.name)
    number = who.counterbalancing_number
    refuse_erased(root, [who.participant], allowed=allow_erased)
    flawed = flaw(experiment, root)
    if flawed:
        tell(flawed)
    withdrawal = Withdrawal(root, session)
    # The session is locked before any device opens, and closed after all devices, even after errors.
    keeper = OpenSession(root, design, session, kind.name, resume=resume)
    try:
        refuse_erased(root, [who.participant], allowed=allow_erased)  # may have been erased before the lock
        if resume and keeper.journal.head is None:
            tell(f"--resume: {root} contains no session {who.session} of {who.participant} to resume; it begins now")
        seed, n_resumed = _session_seed(keeper.journal.head, who, kind), keeper.tally.n_trials
        if keeper.repaired:
            tell(keeper.repaired)
        if keeper.journal.head is None and who.seed is None and kind.name == SIMULATED:
            tell(f"seed: {seed} (repeat with this --seed)")
        with closing(_made(kind, seed, keeper, withdrawal)) as rig:
            _begin(keeper, _head(design, who, seed, kind, rig, keeper), tell)
            course = experiment.course(who.participant, who.session, number, seed)
            tracks = run(course, rig, keeper)
    finally:
        keeper.close()
    return Recorded(keeper.trials, keeper.tally, n_resumed, tracks, keeper.repaired)


def _made(kind: RigKind, seed: int, keeper: OpenSession, withdrawal: Withdrawal) -> Rig:
    """Open the rig. If it cannot open, the new session is removed."""
    try:
        return kind.make(seed, keeper)
    except BaseException:
        withdrawal.undo()  # undone before the journal is closed, while no other process can begin this session
        raise


def _begin(keeper: OpenSession, head: Head, tell: Callable[[str], None]) -> None:
    """Write the head of a sitting, and report changes since the last one."""
    if keeper.journal.recording.complete:
        return  # a completed session has no further sitting
    changed = [phrase for last in keeper.journal.recording.sittings[-1:] for phrase in differences(last, head)]
    if changed:
        tell(f"changes since the last part of this session: {'; '.join(changed)}")
    keeper.journal.begin(head)


def _session_seed(head: Head | None, who: Who, kind: RigKind) -> int:
    number = who.counterbalancing_number
    if head is None:
        return secrets.randbelow(2**32) if who.seed is None else who.seed
    if kind.name != head.rig:
        raise InvalidParameter(f"--rig: found {kind.name}, but this session began with {head.rig}; continue with it")
    seed = head.seed if who.seed is None else who.seed
    for name, value, begun in (("seed", seed, head.seed), ("number", number, head.number)):
        if value != begun:
            raise InvalidParameter(
                f"--{name}: found {value}, but this session began with {begun}; leave it out to continue"
            )
    return head.seed


def _head(design: StudyDescription, who: Who, seed: int, kind: RigKind, rig: Rig, keeper: OpenSession) -> Head:
    started = None if kind.simulated_time else datetime.now(UTC).isoformat(timespec="milliseconds")
    return Head(
        study=design.study,
        study_sha256=sha256(design.study_toml),
        participant=who.participant,
        session=who.session,
        number=who.counterbalancing_number,
        seed=seed,
        rig=kind.name,
        versions=versions(),
        facts=rig.facts(),
        observer=kind.observer(seed),
        started_utc=started,
        begun_s=keeper.replay.elapsed_s,
        format=keeper.format,
    )
