"""What a session would ask, without asking it."""

from collections.abc import Iterator
from dataclasses import dataclass

from tactometry.errors import counted
from tactometry.experiments.procedures import Rule
from tactometry.experiments.wiring import Experiment
from tactometry.protocols.block import Block
from tactometry.protocols.rating import Rating
from tactometry.protocols.session import Inquiry, Part
from tactometry.streams import stream

ITEM_S = 5.0
"""What an item of a questionnaire takes a participant (unverified default)."""


@dataclass(frozen=True)
class PlannedBlock:
    """One part: its number, its factors, its procedure or questionnaire, how many tracks are interleaved, and at most
    how many trials and items it takes, catch trials with them."""

    block: int
    factors: dict[str, float | str]
    procedure: str
    n_trials_at_most: int
    n_tracks: int = 1
    n_items: int = 0
    practice: bool = False

    @property
    def content(self) -> str:
        """What it holds, in words.

        >>> PlannedBlock(1, {}, "staircase", 80, n_tracks=2).content
        'staircase, 2 interleaved, at most 80 trials'
        """
        parts = [
            self.procedure,
            f"{self.n_tracks} interleaved" if self.n_tracks > 1 else "",
            f"at most {counted(self.n_trials_at_most, 'trial')}" if self.n_trials_at_most else "",
            counted(self.n_items, "item") if self.n_items else "",
        ]
        return ", ".join(filter(None, parts))


def plan(experiment: Experiment, number: int, n_session: int = 1, seed: int = 0) -> list[PlannedBlock]:
    """The parts of a session of the participant with this number."""
    parts = experiment.parts(number, stream(seed, "plan"), n_session, seed)
    return [_planned(n, part) for n, part in enumerate(parts, 1)]


def _planned(number: int, part: Part) -> PlannedBlock:
    if isinstance(part, Inquiry):
        return PlannedBlock(number, {}, part.form.name, 0, 0, len(part.form.items))
    assert isinstance(part, Block)
    n_trials = sum(_n_trials(part))
    n_items = n_trials * len(part.task.form.items) if isinstance(part.task, Rating) else 0
    factors = {name: level for name, level in part.factors.items() if level != ""}
    procedure = part.tracks[0].procedure.name
    return PlannedBlock(number, factors, procedure, n_trials, len(part.tracks), n_items, part.practice)


def _n_trials(block: Block) -> Iterator[int]:
    rate = block.catch_rate if block.task.takes_catch_trials else 0.0
    for track in block.tracks:
        n_stimuli = Rule(track.procedure).n_trials_at_most
        yield n_stimuli if rate == 0 else round(n_stimuli / (1 - 1 / max(round(1 / rate), 2)))


def duration_s(experiment: Experiment, blocks: list[PlannedBlock]) -> float:
    """How long a session takes at most, at the study's time per trial and `ITEM_S` per item."""
    return sum(experiment.study.trial_s * block.n_trials_at_most + ITEM_S * block.n_items for block in blocks)
