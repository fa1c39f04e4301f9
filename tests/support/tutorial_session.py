"""Sessions of the tutorial of constant stimuli with a simulated participant, which many tests record and then spoil."""

from study_texts import TUTORIAL

from tactometry.experiments.sessions.recording import Who, record, simulated
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import parse

TOML = TUTORIAL.encode()
STUDY = parse(TOML, "tutorial")
EXPERIMENT = wire(STUDY, "tutorial")
WHO = Who("P01", seed=1)


def live(root, who=WHO, *, resume=False):
    """Record a session in `root`, or the rest of it."""
    return record(EXPERIMENT, TOML, root, who, simulated(EXPERIMENT, who), resume=resume)


def journal_of(root):
    return next((root / "journals").glob("*study-tutorial.jsonl"))
