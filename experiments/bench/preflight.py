"""Preflight: what a session needs, tried before a participant comes."""

from pathlib import Path

from tactometry.errors import TactometryError

from ..study.dry_run import felt_of
from ..study.experiment import Experiment, wire
from ..study.study_file import load
from .bench_file import BenchFile
from .finding import Finding, findings_of
from .preflight_computer import computer, disk, display, existing
from .preflight_devices import devices


def check(study: str | None, bench: BenchFile, folder: Path, *, hands_off: bool) -> list[Finding]:
    """Everything in turn; what fails is a finding, and the rest is looked at all the same.

    Parameters
    ----------
    study : str, optional
        Name or path; its limits hold beside those of the bench.
    bench : BenchFile
    folder : Path
        Where data would be written.
    hands_off : bool
        Whether somebody said that nobody touches the surface: a connected output plays nothing without it.
    """
    findings, experiment = _study(study) if study is not None else ([], None)
    limits = experiment.study.limits if experiment is not None else bench.limits
    findings += findings_of("computer", computer())
    findings += findings_of("disk", disk(existing(folder)))
    findings += findings_of("display", display(bench.screen, existing(folder)))
    findings += findings_of("devices", devices(bench, limits, experiment, hands_off=hands_off))
    return findings


def _study(study: str) -> tuple[list[Finding], Experiment | None]:
    try:
        experiment = wire(load(study)[0], study)
    except TactometryError as error:
        return [Finding("study", study, str(error), "a study that can run", fine=False)], None
    n = len(experiment.bank)
    words = f"{n} {'stimulus' if n == 1 else 'stimuli'}; the strongest levels are within the study's limits"
    felt = [Finding("scene", "felt", " ".join(map(str.strip, each.lines))) for each in felt_of(experiment)]
    return [Finding("study", study, words, fine=True), *felt], experiment
