"""The stimuli of a study on a bench whose impulse responses were learnt."""

from collections.abc import Mapping
from pathlib import Path

from tactometry.errors import InvalidParameter, TactometryError
from tactometry.rigs.emitter import render
from tactometry.signal import Stimulus

from ..study.experiment import Experiment
from .bench_file import Learnt


def bank_of(experiment: Experiment, learnt: Learnt | None) -> Mapping[str, Stimulus]:
    """The stimuli by name; the kinds `focus`, `pattern` and `hybrid` from the learnt responses, where there are any.

    Raises
    ------
    InvalidFile
        If the file cannot be read.
    InvalidParameter
        If the responses do not suit a stimulus, or its highest level needs more than the amplifier has.
    """
    if learnt is None:
        return experiment.bank
    from tactometry.stimuli import hybrid
    from tactometry.stimuli.time_reversal.responses.measured import read
    from tactometry.stimuli.time_reversal.stimulus import focus_train

    heard = read([Path(learnt.responses)])

    def suited(stimulus: Stimulus) -> Stimulus:
        match stimulus:
            case focus_train.FocusTrain():
                return focus_train.measured(stimulus, heard)
            case hybrid.Hybrid():
                return hybrid.measured(stimulus, heard)
        return stimulus

    bank: dict[str, Stimulus] = {}
    for strongest in experiment.strongest():
        try:
            bank[strongest.name] = suited(strongest.stimulus)
            render(bank, strongest.name, strongest.level, limits=None)
        except TactometryError as error:
            raise InvalidParameter(f"time_reversal.responses, {learnt.responses}, {strongest.name}: {error}") from None
    return bank


def learnt_facts(learnt: Learnt | None) -> dict[str, str | None]:
    """What a journal says of the responses: their file, its digest, when and by whom they were measured."""
    if learnt is None:
        return {}
    from tactometry.provenance import sha256
    from tactometry.stimuli.time_reversal.responses.learning import read_provenance

    path = Path(learnt.responses)
    said = read_provenance(path) if path.suffix == ".npz" else {}
    when = " ".join(str(said[key]) for key in ("measured_on", "measured_by") if key in said)
    return {
        "responses": path.name,
        "responses_sha256": sha256(path.read_bytes()),
        "responses_measured": when or None,
    }
