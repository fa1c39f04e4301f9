"""Command line: a table of commands, each imported when it is called."""

import signal
import sys
from types import FrameType

import click

from .. import __version__
from ..errors import SIGNALLED, TactometryError, Terminated, each_of, nearest
from ..files.durable import private
from ..loading import resolve

GROUPS = {
    "Get started": {
        "demo": ("simulate:demo", "Simulate a study, analyse it and write its report."),
        "studies": ("studies:studies", "List the built-in studies."),
        "new": ("studies:new", "Copy a built-in study to a file to edit."),
        "keys": ("keys:command", "Explain the keys of study, bench, scene and map files."),
    },
    "Sessions": {
        "check": ("check:command", "Check display, devices, limits and disk before a session."),
        "run": ("run:command", "Run a session with a participant, or a simulated one."),
        "watch": ("watch:command", "Follow a running session in the browser."),
        "calibrate": ("calibrate:command", "Calibrate output gain, force sensor, display and plate."),
    },
    "Data": {
        "analyse": ("analyse:command", "Estimate thresholds, test conditions and write a report."),
        "show": ("show:command", "Plot one trial: force, position and emitted signal."),
        "validate": ("data_sets:validate", "Check a data set and list every defect with its file and row."),
        "replay": ("data_sets:replay", "Check that a recorded session follows its protocol."),
        "rebuild": ("data_sets:rebuild", "Rebuild the tables of a data set from its journals."),
        "export": ("data_sets:export", "Export a data set to BIDS, Psych-DS, PsychoPy, jsPsych or R."),
        "erase": ("data_sets:erase", "Erase the data of one participant."),
    },
    "Planning": {
        "simulate": ("simulate:simulate", "Run a study with simulated participants."),
        "power": ("power:command", "Estimate the power of a study by simulation."),
        "sources": ("sources:command", "List the parameters that simulated results rest on."),
    },
    "Physics": {
        "scene": ("scene:command", "Compute the physics of a scene at its stated accuracy."),
        "design": ("design:command", "Design a time-reversal screen."),
    },
    "Checks of the program": {
        "validate-method": ("validate_method:command", "Validate procedures, fits and tests by simulation."),
        "cost": ("cost:command", "Measure time and memory against accuracy."),
        "reproduce": ("reproduce:command", "Reproduce tables, figures and findings of the thesis."),
    },
}
"""Target in this package and summary of each command, by the heading under which `--help` lists it."""
COMMANDS = {name: entry for group in GROUPS.values() for name, entry in group.items()}


class Commands(click.Group):
    """Group of the commands in the table. `--help` imports none of them."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        del ctx
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            names = ", ".join(COMMANDS)
            ctx.fail(f"found no command {cmd_name!r}, expected one of {names}{nearest(cmd_name, COMMANDS)}")
        command: click.Command = resolve(f"{__name__}.{COMMANDS[cmd_name][0]}")
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        del ctx
        width = max(map(len, COMMANDS))
        for heading, commands in GROUPS.items():
            with formatter.section(heading):
                formatter.write_dl([(f"{name:<{width}}", summary) for name, (_, summary) in commands.items()])


@click.command(
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100, "show_default": True},
    epilog="Start with: tactometry demo",
)
@click.version_option(__version__, prog_name="tactometry")
def tactometry() -> None:
    """Run, simulate and analyse psychophysics experiments on touch."""


_ENDING = [signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else [])]
"""Signals that end a command cleanly. This includes a closed terminal, except under nohup."""


MOST_MISTAKES = 20
"""Largest number of errors printed for one file."""
_IS_SAFE = "recorded data are safe"
_HOW_TO_CONTINUE = {
    **dict.fromkeys(("run", "simulate", "power", "validate-method"), f"{_IS_SAFE}: continue with --resume"),
    "erase": "run the command again to finish the erasure",
}


def _terminate(number: int, frame: FrameType | None) -> None:
    del frame
    raise Terminated(SIGNALLED + number)


def main(arguments: list[str] | None = None) -> None:
    """Run a command, and print an expected error as one line."""
    for number in _ENDING:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _terminate)
    words = sys.argv[1:] if arguments is None else arguments
    try:
        with private():
            status = tactometry.main(words or ["--help"], prog_name="tactometry", standalone_mode=False)
    except (click.Abort, KeyboardInterrupt):
        status = _complain(f"interrupted; {_HOW_TO_CONTINUE.get(''.join(words[:1]), _IS_SAFE)}", 130)
    except click.ClickException as error:
        status = _complain(f"{_where(error)}{error.format_message()}", 2)
    except TactometryError as error:
        more = resolve("tactometry.cli.keys:hint_of_keys")
        parts = each_of(error)
        for part in parts[:MOST_MISTAKES]:
            status = _complain(f"{part}{more(part)}", error.exit_status)
        if len(parts) > MOST_MISTAKES:
            status = _complain(f"found {len(parts) - MOST_MISTAKES} more errors", error.exit_status)
    except BrokenPipeError:
        sys.stderr.close()
        status = 0
    except OSError as error:
        if error.filename is None:
            raise
        status = _complain(f"{error.filename}: cannot be used ({error.strerror}), expected a usable file or folder", 2)
    except MemoryError:
        status = _complain("found too little memory for this request, expected a smaller request", 2)
    sys.exit(status or 0)


def _where(error: click.ClickException) -> str:
    context = getattr(error, "ctx", None)
    return f"{context.info_name}: " if context is not None and context.parent is not None else ""


def _complain(text: str, status: int) -> int:
    print(f"tactometry: {' '.join(text.split())}", file=sys.stderr)
    return status
