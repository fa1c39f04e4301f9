"""Many simulated participants of one study, on disk or in memory."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from tactometry.analysis.reading.text_table import TEXT
from tactometry.analysis.reading.trials import Trials, trials_in
from tactometry.arguments.require import expect
from tactometry.errors import rewording
from tactometry.records.data_set import Session, values_of
from tactometry.records.description import SIMULATED
from tactometry.records.erasures import refuse_erased
from tactometry.records.head import LARGEST_SEED
from tactometry.session.replay import Replay
from tactometry.session.request import Record, Request
from tactometry.session.run import run
from tactometry.trials.cells import Value, cell
from tactometry.trials.row_rules import COUNTS, FLAGS, NUMBERS
from tactometry.trials.trial import Trial
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


NUMERIC: Final = frozenset((*NUMBERS, *COUNTS, *FLAGS))
NOWHERE: Final = Path("simulated in memory")
"""Placeholder for the folder of a data set in messages."""


class Collector:
    """Keeper that stores a session's trials only in memory."""

    def __init__(self) -> None:
        self.trials: list[Trial] = []
        self.replay = Replay(())

    def append(self, request: Request[Any], answer: object) -> None:
        del answer
        if isinstance(request, Record):
            self.trials.append(request.trial)

    def finish(self) -> None:
        pass


def simulated_session(experiment: Experiment, who: Who) -> tuple[Trial, ...]:
    """Return the trials of a simulated session with a given seed.

    >>> from ..study.experiment import wire
    >>> from ..study.study_file import load
    >>> experiment = wire(load("tutorial")[0], "tutorial")
    >>> [trial.level for trial in simulated_session(experiment, Who("P01", seed=1))[:3]]
    [46.0, 38.0, 42.0]
    """
    collector, seed = Collector(), who.seed or 0
    rig = experiment.simulated_rig(who.participant, who.session, seed)
    run(experiment.course(who.participant, who.session, who.counterbalancing_number, seed), rig, collector)
    return tuple(collector.trials)


def simulated_trials(experiment: Experiment, sessions: Iterable[Who]) -> Trials:
    """Simulate sessions in memory, and return them like a read data set.

    >>> from ..study.experiment import wire
    >>> from ..study.study_file import load
    >>> experiment = wire(load("tutorial")[0], "tutorial")
    >>> simulated_trials(experiment, [Who("P01", seed=1), Who("P02", seed=1)]).rows["participant"].unique().tolist()
    ['P01', 'P02']
    """
    return trials_in(dict(_table(experiment, who) for who in sessions), NOWHERE)


def trials_of(simulation: Simulation, *, n_jobs: int = 1, scheduler: str | None = None) -> Trials:
    """Simulate all sessions like `simulated_trials`, on several processes.

    The result does not depend on where it is computed.

    >>> from ..study.study_file import load
    >>> trials_of(Simulation(load("tutorial")[1], "tutorial", NOWHERE, n_participants=2, seed=1)).n_files
    2
    """
    simulation.check()
    with workers(n_jobs, scheduler) as spread:
        return trials_in(dict(spread(partial(_table_of, simulation), simulation.sessions())), NOWHERE)


def _table_of(simulation: Simulation, who: Who) -> tuple[Path, pd.DataFrame]:
    return _table(simulation.experiment(), who)


def _table(experiment: Experiment, who: Who) -> tuple[Path, pd.DataFrame]:
    """Simulate a session, and return its file name and table."""
    session = Session(who.participant, who.session, experiment.study.name)
    columns = experiment.design(b"").columns
    known = [values_of(trial, session, SIMULATED) for trial in simulated_session(experiment, who)]
    by_name = {column.name: [values.get(column.name) for values in known] for column in columns}
    table = pd.DataFrame({name: _column(name, values) for name, values in by_name.items()})
    return session.trials(NOWHERE), table.assign(row=range(2, len(known) + 2))


def _column(name: str, values: Sequence[Value]) -> Any:
    """Return a numeric column as numbers, other columns as text."""
    if name in NUMERIC and all(value is None or isinstance(value, int | float) for value in values):
        numbers = np.array(values, dtype=np.float64)  # None becomes NaN
        if np.isfinite(numbers).sum() == len(values) - values.count(None):
            return numbers + 0.0  # negative zeros become 0, as in a file
    return pd.array([cell(value) for value in values], dtype=TEXT)
