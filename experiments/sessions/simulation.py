"""Many simulated participants of one study."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from tactometry.arguments.require import expect
from tactometry.errors import rewording
from tactometry.records.erasures import refuse_erased
from tactometry.records.head import LARGEST_SEED
from tactometry.user_code import state_of

from ..study.experiment import Experiment, wire
from ..study.rehearsal import flaw
from ..study.session_plan import all_sessions
from ..study.study_file import parse
from ..workers import workers
from .recording import Recorded, Who, record, simulated

MOST_PARTICIPANTS = 100_000


@dataclass(frozen=True)
class Simulation:
    """Simulated participants, with custom code from `code_from`."""

    study_toml: bytes
    where: str
    root: Path
    n_participants: int
    seed: int
    resume: bool = False
    code_from: Path | None = None
    allow_erased: bool = False

    def __post_init__(self) -> None:
        n, seed = self.n_participants, self.seed
        expect(n >= 1, "--participants", n, "at least 1")
        expect(n <= MOST_PARTICIPANTS, "--participants", n, f"at most {MOST_PARTICIPANTS}")
        expect(seed >= 0, "--seed", seed, "a whole number, at least 0")
        expect(seed <= LARGEST_SEED, "--seed", seed, f"a whole number, at most {LARGEST_SEED}")

    def sessions(self) -> list[Who]:
        """Return every planned session of every participant."""
        width = max(2, len(str(self.n_participants)))
        study = parse(self.study_toml, self.where)
        return [
            Who(f"P{n:0{width}d}", session, seed=self.seed)
            for n in range(1, self.n_participants + 1)
            for session in range(1, len(all_sessions(study, None, n, self.seed)) + 1)
        ]

    def experiment(self) -> Experiment:
        state = "" if self.code_from is None else state_of(self.code_from)
        return _wired(self.study_toml, self.where, self.code_from, state)

    def check(self) -> Experiment:
        """Raise `InvalidParameter` for custom code that is not allowed."""
        experiment = self.experiment()
        with rewording(lambda words: f"{self.where}, {words}"):
            experiment.check_allowed()
        return experiment

    def record(self, who: Who) -> Recorded:
        """Record one session of one simulated participant."""
        experiment = self.experiment()
        kind, allowed = simulated(experiment, who), self.allow_erased
        return record(experiment, self.study_toml, self.root, who, kind, resume=self.resume, allow_erased=allowed)


@lru_cache(maxsize=1)
def _wired(study_toml: bytes, where: str, code_from: Path | None, state: str) -> Experiment:
    """Wire a study once for all sessions of a process."""
    del state
    return wire(parse(study_toml, where), where, code_from)


def simulate(simulation: Simulation, *, n_jobs: int = 1, scheduler: str | None = None) -> Iterator[Recorded]:
    """Yield finished sessions from `n_jobs` processes or a Dask cluster.

    The result does not depend on where it is computed.
    """
    flaw(simulation.check(), simulation.root)
    codes = [who.participant for who in simulation.sessions()]
    refuse_erased(simulation.root, codes, allowed=simulation.allow_erased)
    if n_jobs != 1 or scheduler is not None:  # other processes may run in another folder
        simulation = replace(simulation, root=simulation.root.absolute())
    with workers(n_jobs, scheduler) as spread:
        yield from spread(simulation.record, simulation.sessions())
