"""Plan the content and duration of a session without running it."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

from tactometry.errors import InvalidParameter, count_of
from tactometry.protocols.block import Block
from tactometry.protocols.session import Inquiry, Part
from tactometry.protocols.tasks.task import AsksForm
from tactometry.session.progress import PartAhead

from .experiment import Experiment
from .session_plan import stream

ITEM_S = 5.0
"""Assumed time for an item of a questionnaire (unverified default)."""
LONG_S, LONGEST_S = 3 * 3600.0, 24 * 3600.0
"""Durations above which a session gives a warning, or an error."""


@dataclass(frozen=True)
class PlannedBlock:
    """Planned block or questionnaire of a session.

    `procedure` may name a questionnaire. `n_trials_at_most` includes catch trials. `n_items` counts the items of a
    questionnaire.
    """

    block: int
    factors: dict[str, float | str]
    procedure: str
    n_trials_at_most: int
    n_tracks: int = 1
    n_items: int = 0
    practice: bool = False

    @property
    def content(self) -> str:
        """Content of the block in words.

        >>> PlannedBlock(1, {}, "staircase", 80, n_tracks=2).content
        'staircase, 2 interleaved, at most 80 trials'
        """
        phrases = [
            self.procedure,
            f"{self.n_tracks} interleaved" if self.n_tracks > 1 else "",
            f"at most {count_of(self.n_trials_at_most, 'trial')}" if self.n_trials_at_most else "",
            count_of(self.n_items, "item") if self.n_items else "",
        ]
        return ", ".join(filter(None, phrases))


def plan(experiment: Experiment, number: int, n_session: int = 1, seed: int = 0) -> list[PlannedBlock]:
    """Return the planned blocks of a session, for a participant number."""
    parts = experiment.parts(number, stream(seed, "plan"), n_session, seed)
    return [_planned_block(n, part) for n, part in enumerate(parts, 1)]


def _planned_block(number: int, part: Part) -> PlannedBlock:
    if isinstance(part, Inquiry):
        return PlannedBlock(number, {}, part.form.name, 0, 0, len(part.form.items))
    assert isinstance(part, Block)
    n_trials = sum(_n_trials(part))
    n_items = n_trials * len(part.task.form.items) if isinstance(part.task, AsksForm) else 0
    factors = {name: level for name, level in part.factors.items() if level != ""}
    procedure = part.tracks[0].procedure.name
    return PlannedBlock(number, factors, procedure, n_trials, len(part.tracks), n_items, part.practice)


def _n_trials(block: Block) -> Iterator[int]:
    # Each group of this many trials contains exactly one catch trial.
    n_group = max(round(1 / block.catch_rate), 2) if block.catch_rate else inf
    for track in block.tracks:
        yield round(track.procedure.n_trials_at_most / (1 - 1 / n_group))


def duration_s(experiment: Experiment, blocks: list[PlannedBlock]) -> float:
    """Return the longest possible duration (s) of a session.

    This is the sum of the times for trials, items (`ITEM_S`) and rests, limited by `longest_s` of plan and task.
    """
    most_s, parts_s = experiment.study.plan.longest_s, [_longest_block_s(experiment, block) for block in blocks]
    return min(sum(parts_s), inf if most_s is None else most_s + max(parts_s, default=0.0))


def _longest_block_s(experiment: Experiment, block: PlannedBlock) -> float:
    options, n_trials = experiment.table.options, block.n_trials_at_most
    trials_s = experiment.study.trial_s * n_trials
    n_rests = (n_trials - 1) // options.rest_after if options.rest_after and n_trials else 0
    n_rests += 0 if options.rest_every_s is None else int(trials_s / options.rest_every_s)
    trials_s += (options.rest_s or 0.0) * n_rests
    return min(trials_s + ITEM_S * block.n_items, inf if options.longest_s is None else options.longest_s)


def parts_ahead(experiment: Experiment, number: int, n_session: int = 1, seed: int = 0) -> tuple[PartAhead, ...]:
    """Return the parts of a session, for `tactometry.session.progress`.

    >>> from .experiment import wire
    >>> from .study_file import load
    >>> [part.n_trials for part in parts_ahead(wire(load("tutorial")[0], "tutorial"), number=1)]
    [35, 35]
    """
    n_attempts = experiment.table.options.n_attempts
    return tuple(
        PartAhead(
            block.factors,
            block.n_trials_at_most,
            _longest_block_s(experiment, block),
            n_attempts if block.n_trials_at_most else None,
        )
        for block in plan(experiment, number, n_session, seed)
    )


def check_duration(experiment: Experiment, blocks: list[PlannedBlock]) -> str | None:
    """Return a warning for a session longer than `LONG_S`, else None.

    Raises `InvalidParameter` if the session lasts more than `LONGEST_S`.
    """
    lasting_s = duration_s(experiment, blocks)
    if lasting_s <= LONG_S:
        return None
    lasts = f"found a session of at most {lasting_s / 3600:.3g} hours"
    ways = "plan fewer trials or several sessions ([plan]: sessions, longest_s)"
    if lasting_s > LONGEST_S:
        raise InvalidParameter(f"procedure: {lasts}, expected at most {LONGEST_S / 3600:g}; {ways}")
    return f"{lasts}, which is more than {LONG_S / 3600:g}: {ways}, or test that participants tolerate it"
