"""What a session would ask, without asking it."""

from dataclasses import dataclass

from tactometry.experiments.wiring import Experiment
from tactometry.protocols.constant_stimuli import ConstantStimuli
from tactometry.streams import stream


@dataclass(frozen=True)
class PlannedBlock:
    """One block: its number, its factors, its procedure, and at most how many trials it takes, catch trials with it."""

    block: int
    factors: dict[str, float | str]
    procedure: str
    n_trials_at_most: int


def plan(experiment: Experiment, number: int) -> list[PlannedBlock]:
    """The blocks of the participant with this number."""
    procedure = experiment.procedure
    n_stimuli = len(procedure.order) if isinstance(procedure, ConstantStimuli) else procedure.n_trials
    rate = experiment.study.task.catch_rate
    n_trials = n_stimuli if rate == 0 else round(n_stimuli / (1 - 1 / max(round(1 / rate), 2)))
    blocks = experiment.blocks(number, stream(0, "plan"))
    return [
        PlannedBlock(n, block.factors, block.tracks[0].procedure.name, n_trials) for n, block in enumerate(blocks, 1)
    ]


def duration_s(experiment: Experiment, blocks: list[PlannedBlock]) -> float:
    """How long a session takes at most, at the study's time per trial."""
    return experiment.study.trial_s * sum(block.n_trials_at_most for block in blocks)
