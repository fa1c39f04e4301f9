"""Rigs of `tactometry run`, built from a study and a bench file."""

import sys
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING

import click

from tactometry.records.description import SIMULATED

# Rigs and devices are imported when one is built, so that other commands start without their libraries.
if TYPE_CHECKING:
    from tactometry.rigs.device_rig import Equipment
    from tactometry.session.event import EventLog

    from ..bench.bench_file import BenchFile
    from ..study.experiment import Experiment
    from .recording import RigKind, Who


def rig_kind(name: str, experiment: "Experiment", who: "Who", bench_file: "BenchFile") -> "RigKind":
    """Return the rig that the function of this name in this module builds."""
    kind: RigKind = globals()[name](experiment, who, bench_file)
    return kind


def check_needs(kind: "RigKind", experiment: "Experiment", who: "Who", bench_file: "BenchFile") -> None:
    """Check a session's needs on a rig without opening a device."""
    if kind.name == SIMULATED:
        kind.observer(who.seed or 0)
        experiment.simulated_rig(who.participant, who.session, who.seed or 0)
    else:
        needed = equipment(experiment, bench_file)
        for sensor in (needed.sensor, needed.position):
            if sensor is not None:
                sensor.reader.source.check()


def equipment(experiment: "Experiment", bench: "BenchFile", log: "EventLog | None" = None) -> "Equipment":
    """Return the closed devices of a bench, with the exposure of the log."""
    from datetime import date

    from tactometry.devices.outputs.output import check_format
    from tactometry.rigs.device_rig import Equipment

    from ..bench.bench_file import device_facts
    from ..bench.stimuli import bank_on, check_followed, learnt_facts

    devices = bench.devices(experiment.study.limits, date.today())
    for caution in (*experiment.study.cautions, *bench.cautions):
        click.echo(caution, err=True)
    bank, learnt = bank_on(experiment, bench), learnt_facts(bench.time_reversal)
    for strongest in experiment.strongest(bank):
        check_format(strongest.signal, devices.output.driver)
    check_followed(experiment, bench, devices)
    if log is not None:
        devices.output.count_on(log.exposure())
    return Equipment(
        devices.output,
        bank,
        bench.limits_with(experiment.study.limits),
        devices.force,
        devices.position,
        bench.output.ramp_s,
        bench.release,
        lambda: device_facts(bench, devices) | learnt,
        bench.screen.height_m,
        bench.traces.kept,
    )


def bench(experiment: "Experiment", who: "Who", bench_file: "BenchFile") -> "RigKind":
    from tactometry.rigs.bench import Bench
    from tactometry.rigs.experimenter.live import experimenter_terminal
    from tactometry.rigs.experimenter.terminal import StatusLine
    from tactometry.rigs.texts import texts_in

    from ..study.dry_run import parts_ahead
    from ..study.rehearsal import page_images
    from .recording import RigKind

    screen = bench_file.screen
    words = texts_in(screen.language, experiment.words_in(screen.language))
    texts = replace(words, images=page_images(experiment))

    def make(seed: int, log: "EventLog") -> Bench:
        devices = replace(equipment(experiment, bench_file, log), dry_run=screen.dry_run)
        parts = parts_ahead(experiment, who.counterbalancing_number, who.session, seed)
        with ExitStack() as on_failure:
            terminal = experimenter_terminal(sys.stdin, sys.stderr)
            on_failure.callback(terminal.close)
            status = StatusLine(terminal, parts)
            log.follow(status.on_request, status.on_event)
            window = screen.window()
            if window.caution is not None:
                terminal.tell(window.caution)
            made = Bench(window, devices, texts, log=log, terminal=terminal)
            on_failure.pop_all()  # the rig closes it from now on
        return made

    return RigKind("bench", make)


def console(experiment: "Experiment", who: "Who", bench_file: "BenchFile") -> "RigKind":
    from tactometry.devices.outputs.output import NullSettings
    from tactometry.errors import InvalidParameter
    from tactometry.rigs.console import Console
    from tactometry.rigs.texts import texts_in
    from tactometry.trials.tasks import TASKS

    from .recording import RigKind

    del who
    language = bench_file.screen.language
    texts = texts_in(language, experiment.words_in(language))
    if TASKS[experiment.table.kind].sets_level and not isinstance(bench_file.output.settings, NullSettings):
        raise InvalidParameter(
            "--rig: found console, which plays no level during an adjustment, expected bench; or remove [output] "
            "from the bench file"
        )

    def make(seed: int, log: "EventLog") -> Console:
        del seed
        return Console(equipment(experiment, bench_file, log), texts, log=log)

    return RigKind("console", make)


def simulated(experiment: "Experiment", who: "Who", bench_file: "BenchFile") -> "RigKind":
    from . import recording

    del bench_file
    experiment.check_allowed()
    return recording.simulated(experiment, who)
