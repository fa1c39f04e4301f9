"""Sessions of the tutorial with a simulated participant, which many tests record and then spoil."""

from tactometry.experiments.recording import Who, record, simulated
from tactometry.experiments.study import load
from tactometry.experiments.wiring import wire

STUDY, TOML = load("tutorial")
EXPERIMENT = wire(STUDY, "tutorial")
WHO = Who("P01", seed=1)


def live(root, who=WHO, *, resume=False):
    """Record a session in `root`, or the rest of it."""
    return record(EXPERIMENT, TOML, root, who, simulated(EXPERIMENT, who), resume=resume)


def journal_of(root):
    return next((root / "journals").glob("*study-tutorial.jsonl"))
