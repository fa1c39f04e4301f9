"""`tactometry run`."""

import math
from contextlib import nullcontext
from dataclasses import asdict
from functools import partial
from pathlib import Path

import click

from tactometry.experiments.bench.bench_file import load_bench
from tactometry.experiments.sessions.recording import Recorded, Who, record
from tactometry.experiments.sessions.rig_kinds import check_needs, rig_kind
from tactometry.experiments.study.dry_run import check_duration, duration_s, plan
from tactometry.experiments.study.experiment import Experiment, wire
from tactometry.experiments.study.rehearsal import rehearse, rehearse_forms
from tactometry.experiments.study.study_file import folder_of, load

from ..errors import InvalidParameter, count_of
from ..records.data_set import Session
from ..records.erasures import refuse_erased
from ..trials.cells import cell
from ..trials.columns import RIGS
from .output import STUDY, allow_code_option, allow_erased_option, bench_option, path_option, say, subcommand
from .watch import watching


@subcommand("run tutorial --participant P01 --rig console --out pilot")
@click.argument("study", type=STUDY)
@click.option("--participant", required=True, help="Code of letters and digits, such as P01; not a name.")
@click.option("--session", "n_session", type=int, default=1, help="Number of the session.")
@click.option("--rig", type=click.Choice(list(RIGS)), default="bench")
@click.option("--number", type=int, help="Number for counterbalancing; default: the last digits of the code.")
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), help="Seed; default: a new one, which is printed.")
@bench_option
@path_option("--out", help="Folder of the data set; default: STUDY-data or STUDY-simulated.")
@click.option("--resume", is_flag=True, help="Continue an interrupted session.")
@allow_code_option
@allow_erased_option
@click.option("--watch", is_flag=True, help="Serve a web page that follows the session, and print its address.")
@click.option("--dry-run", is_flag=True, help="Check the session without its devices, and print its plan.")
def command(
    *,
    study: str,
    participant: str,
    n_session: int,
    rig: str,
    number: int | None,
    seed: int | None,
    bench_path: Path | None,
    out: Path | None,
    resume: bool,
    allow_code: bool,
    allow_erased: bool,
    watch: bool,
    dry_run: bool,
) -> int:
    """Run a session of STUDY (a built-in name or a path).

    Exit status 1 if a block or one of its tracks did not finish.
    """
    numbers, content = load(study)
    code_from = folder_of(study) if allow_code else None
    experiment = wire(numbers, study, code_from, simulated=rig == "simulated", begun=resume)
    who = Who(Session(participant, n_session, numbers.name).participant, n_session, number, seed)
    root = out or Path(f"{numbers.name}-{'simulated' if rig == 'simulated' else 'data'}")
    refuse_erased(root, [participant], allowed=allow_erased)
    bench = load_bench(bench_path)
    if rig != "simulated":
        rehearse_forms(experiment, bench.screen.language)
        _check_duration(experiment, who, begun=resume)
    kind = rig_kind(rig, experiment, who, bench)
    if dry_run:
        rehearse(experiment)
        check_needs(kind, experiment, who, bench)
        _print_plan(experiment, who)
        return 0
    with watching(root, participant, n_session) if watch else nullcontext() as page:
        if page is not None:
            _tell(f"watch the session at {page}")
        recorded = record(experiment, content, root, who, kind, resume=resume, allow_erased=allow_erased, tell=_tell)
    return _report(root, recorded)


def _check_duration(experiment: Experiment, who: Who, *, begun: bool) -> None:
    """Warn of a long session, and refuse an excessive one unless it has begun."""
    planned = plan(experiment, who.counterbalancing_number, who.session, who.seed or 0)
    try:
        caution = check_duration(experiment, planned)
    except InvalidParameter as too_long:
        if not begun:
            raise
        caution = str(too_long)
    if caution:
        _tell(caution)


_tell = partial(click.echo, err=True)
LOST = {"aborted", "not begun"}
UNFINISHED = LOST | {"skipped"}
ENDINGS = {
    "trials": "reached their last trial",
    "censored_above": "censored above the levels",
    "censored_below": "censored below the levels",
}
"""Printed names of endings that differ from the recorded names."""


def _print_plan(experiment: Experiment, who: Who) -> None:
    from tactometry.experiments.study.felt_effects import predict

    blocks = plan(experiment, who.counterbalancing_number, who.session, who.seed or 0)
    minutes = duration_s(experiment, blocks) / 60
    rows = [
        f"{block.block:>5}  {', '.join(f'{name} {cell(level)}' for name, level in block.factors.items())}"
        f"  ({block.content})"
        for block in blocks
    ]
    drawn = "random" in experiment.study.plan.orders and who.seed is None
    notes = ["the order is random; shown for --seed 0"] if drawn else []
    longest = f"at most {count_of(math.ceil(minutes), 'minute')}, without repeated trials"
    predicted = predict(experiment)
    plan_record = {"blocks": [asdict(block) for block in blocks], "minutes_at_most": minutes}
    say("\n".join(["block", *rows, *notes, longest, *predicted.lines]), plan_record | predicted.record)


def _report(root: Path, recorded: Recorded) -> int:
    counts = recorded.endings
    failed = bool(UNFINISHED & counts.keys())
    missed = "; the practice ended without meeting its criterion" if recorded.practice_missed else ""
    text = f"{recorded.trials}: {recorded.tally}{_ending_words(counts)}{missed}; next: {_advice(counts, root)}"
    result = {
        "data_set": str(root),
        "trials_file": str(recorded.trials),
        "trials": recorded.n_trials,
        "presentations": recorded.tally.n_presented,
        "not_valid": recorded.tally.n_invalid,
        "ended": counts,
        "practice_missed": recorded.practice_missed,
    }
    say(text, result)
    return int(failed)


def _advice(counts: dict[str, int], root: Path) -> str:
    """Return the next step for the user.

    >>> _advice({"not begun": 2}, Path("d")), _advice({"skipped": 1, "aborted": 1}, Path("d"))
    ('nothing to analyse: no block was finished', 'tactometry analyse d')
    """
    if not counts or counts.keys() - LOST:
        return f"tactometry analyse {root}"
    what = "correct the cause of the invalid touches" if "aborted" in counts else "nothing to analyse"
    return f"{what}: no block was finished"


def _ending_words(counts: dict[str, int]) -> str:
    """Describe how the procedures of a session ended.

    >>> _ending_words({"trials": 2, "aborted": 1})
    '; 3 procedures: 2 reached their last trial, 1 aborted'
    """
    if not counts:
        return ""
    endings = [f"{n} {ENDINGS.get(ending, ending)}" for ending, n in counts.items()]
    return f"; {count_of(sum(counts.values()), 'procedure')}: {', '.join(endings)}"
