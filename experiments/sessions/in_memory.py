"""Trials of simulated participants in memory, without files."""

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from tactometry.analysis.reading.text_table import TEXT
from tactometry.analysis.reading.trials import Trials, trials_in
from tactometry.records.data_set import Session, values_of
from tactometry.records.description import SIMULATED
from tactometry.session.replay import Replay
from tactometry.session.request import Record, Request
from tactometry.session.run import run
from tactometry.trials.cells import Value, cell
from tactometry.trials.row_rules import COUNTS, FLAGS, NUMBERS
from tactometry.trials.trial import Trial

from ..study.experiment import Experiment
from ..workers import workers
from .recording import Who
from .simulation import Simulation

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
