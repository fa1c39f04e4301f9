"""The command line: a table of commands, each imported when it is called."""

import signal
import sys
from types import FrameType

import click

from .. import __version__
from ..errors import SIGNALLED, TactometryError, Terminated, each_of, nearest
from ..files.durable import private
from ..loading import resolve

COMMANDS = {
    "demo": ("tactometry.cli.simulate:demo", "A simulated study, its analysis and report, end to end."),
    "studies": ("tactometry.cli.studies:studies", "The built-in studies, a line each."),
    "keys": ("tactometry.cli.keys:command", "The keys of a table of a study, bench, scene or map file."),
    "new": ("tactometry.cli.studies:new", "A copy of a built-in study file to edit."),
    "run": ("tactometry.cli.run:command", "Run a session: bench, console or simulated participant."),
    "watch": ("tactometry.cli.watch:command", "A page in the browser that follows a session while it runs."),
    "simulate": ("tactometry.cli.simulate:simulate", "Run a study with simulated participants."),
    "power": ("tactometry.cli.power:command", "How often a study would find an effect: power by simulation."),
    "replay": ("tactometry.cli.data_sets:replay", "Feed recorded answers back; name the first divergence."),
    "validate": ("tactometry.cli.data_sets:validate", "Is this a sound data set? Every defect, with file and row."),
    "show": ("tactometry.cli.show:command", "What happened in one trial: force, position, what was emitted."),
    "rebuild": ("tactometry.cli.data_sets:rebuild", "Trials and events files, written anew from the journals."),
    "analyse": ("tactometry.cli.analyse:command", "Thresholds with intervals, ANOVA, tables and a report."),
    "calibrate": ("tactometry.cli.calibrate:command", "Output gain, force sensor, display, impulse responses."),
    "check": ("tactometry.cli.check:command", "Before a session: display, devices, limits, disk, threads."),
    "export": ("tactometry.cli.data_sets:export", "The data set for other programs: BIDS, PsychoPy, R."),
    "erase": ("tactometry.cli.data_sets:erase", "Erase one participant, with a record that it was done."),
    "scene": ("tactometry.cli.scene:command", "The physics of a scene: only what is called for, as finely as asked."),
    "cost": ("tactometry.cli.cost:command", "What accuracy costs in time, emission and trials."),
    "reproduce": ("tactometry.cli.reproduce:command", "The thesis's tables, figures and findings, made anew."),
    "validate-method": (
        "tactometry.cli.validate_method:command",
        "Our procedures, fits and tests, put to known truths.",
    ),
    "design": ("tactometry.cli.design:command", "Time-reversal screens: what is wanted, what can be reached and why."),
}

GROUPS = {
    "Begin": ("demo", "studies", "new", "keys"),
    "Sessions": ("check", "run", "watch", "calibrate"),
    "Data": ("analyse", "show", "validate", "replay", "rebuild", "export", "erase"),
    "Planning": ("simulate", "power"),
    "Physics": ("scene", "design"),
    "Checks of the program": ("validate-method", "cost", "reproduce"),
}
"""Commands by the heading under which `--help` lists them."""


class Commands(click.Group):
    """Commands of the table; `--help` imports none of them."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        del ctx
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            names = ", ".join(COMMANDS)
            ctx.fail(f"found no command {cmd_name!r}, expected one of {names}{nearest(cmd_name, COMMANDS)}")
        command: click.Command = resolve(COMMANDS[cmd_name][0])
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        del ctx
        grouped = {name for names in GROUPS.values() for name in names}
        width = max(map(len, COMMANDS))
        for heading, names in {**GROUPS, "Other": [name for name in COMMANDS if name not in grouped]}.items():
            if names:
                with formatter.section(heading):
                    formatter.write_dl([(f"{name:<{width}}", COMMANDS[name][1]) for name in names])


@click.command(
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Start with: tactometry demo",
)
@click.version_option(__version__, prog_name="tactometry")
def tactometry() -> None:
    """Psychophysics on touch: run, simulate and analyse experiments."""


_ENDING = [signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else [])]
"""Signals that end a command cleanly. A closed terminal counts, except under nohup."""


_IS_SAFE = "recorded data are safe"
MOST_MISTAKES = 20
"""Largest number of mistakes printed for one file."""
_WAYS_ON = {
    **dict.fromkeys(("run", "simulate", "power", "validate-method"), f"{_IS_SAFE}: continue with --resume"),
    "erase": "say it again: what was begun is finished",
}


def _terminate(number: int, frame: FrameType | None) -> None:
    del frame
    raise Terminated(SIGNALLED + number)


def main(arguments: list[str] | None = None) -> None:
    """Run a command; a foreseen error becomes a line on standard error and an exit status."""
    for number in _ENDING:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _terminate)
    words = sys.argv[1:] if arguments is None else arguments
    try:
        with private():
            status = tactometry.main(words or ["--help"], prog_name="tactometry", standalone_mode=False)
    except (click.Abort, KeyboardInterrupt):
        status = _complain(f"interrupted; {_WAYS_ON.get(''.join(words[:1]), _IS_SAFE)}", 130)
    except click.ClickException as error:
        status = _complain(f"{_where(error)}{error.format_message()}", 2)
    except TactometryError as error:
        more = resolve("tactometry.cli.keys:where_keys_are_told")
        parts = each_of(error)
        for part in parts[:MOST_MISTAKES]:
            status = _complain(f"{part}{more(part)}", error.exit_status)
        if len(parts) > MOST_MISTAKES:
            status = _complain(f"found {len(parts) - MOST_MISTAKES} more mistakes", error.exit_status)
    except BrokenPipeError:
        sys.stderr.close()
        status = 0
    except OSError as error:
        if error.filename is None:
            raise
        status = _complain(f"{error.filename}: cannot be used ({error.strerror}), expected a file or folder to use", 2)
    except MemoryError:
        status = _complain("the memory of this computer does not hold what was asked for, expected less", 2)
    sys.exit(status or 0)


def _where(error: click.ClickException) -> str:
    context = getattr(error, "ctx", None)
    inside = context is not None and context.parent is not None
    return f"{context.info_name}: " if inside and context is not None else ""


def _complain(text: str, status: int) -> int:
    print(f"tactometry: {' '.join(text.split())}", file=sys.stderr)
    return status
