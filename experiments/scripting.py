"""Run and simulate studies from Python, like `run` and `simulate`."""

from collections.abc import Callable
from pathlib import Path
from typing import Literal

from tactometry.analysis.reading.trials import Trials
from tactometry.arguments.checked import checked

from .bench.bench_file import load_bench
from .sessions.in_memory import NOWHERE, trials_of
from .sessions.recording import Recorded, Who, record
from .sessions.rig_kinds import rig_kind
from .sessions.simulation import Simulation
from .study.experiment import wire
from .study.study_file import load
from .workers import check_workers


@checked
def run(
    study: str | Path,
    participant: str,
    *,
    out: str | Path,
    rig: Literal["bench", "console", "simulated"] = "bench",
    bench: str | Path | None = None,
    session: int = 1,
    seed: int | None = None,
    resume: bool = False,
    tell: Callable[[str], None] = print,
) -> Recorded:
    """Run a session of a study and record it.

    Parameters
    ----------
    study : str or Path
        Name of a built-in study, or path of a study file.
    participant : str
        Code of letters and digits that ends with a number, such as P01.
    out : str or Path
        Folder of the data set.
    rig : str
        ``bench`` (a window and the devices of the bench file), ``console`` or ``simulated``.
    bench : str or Path, optional
        Path of a bench file.
    seed : int, optional
        Seed of the session. Drawn by default.
    resume : bool
        Continue an interrupted session.
    tell : callable
        Called with each message for the experimenter.

    Returns
    -------
    Recorded

    Raises
    ------
    InvalidFile, InvalidParameter
        If a file or an argument is invalid, or the session is already recorded.
    """
    numbers, content = load(str(study))
    experiment = wire(numbers, str(study), simulated=rig == "simulated", begun=resume)
    who = Who(participant, session, seed=seed)
    kind = rig_kind(rig, experiment, who, load_bench(None if bench is None else Path(bench)))
    return record(experiment, content, Path(out), who, kind, resume=resume, tell=tell)


@checked
def simulate(study: str | Path, n_participants: int, *, seed: int, n_jobs: int = 1) -> Trials:
    """Simulate participants and return their trials. Writes no file.

    The same seed gives the same trials, however many processes (`n_jobs`) compute them.

    Raises
    ------
    InvalidFile, InvalidParameter
        If the study file or an argument is invalid.

    >>> simulate("tutorial", 2, seed=1).rows["participant"].unique().tolist()
    ['P01', 'P02']
    """
    check_workers(n_jobs, None)
    _, content = load(str(study))
    return trials_of(Simulation(content, str(study), NOWHERE, n_participants, seed), n_jobs=n_jobs)
