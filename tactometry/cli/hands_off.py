"""Before something plays that no gate stops: somebody says that no hand is on the surface."""

import sys
from typing import Final

import click

WORDS: Final = "hands off"

hands_off_option = click.option(
    "--hands-off", is_flag=True, help="No hand is on the surface: an output that leads to an amplifier may play."
)


def hands_are_off() -> bool:
    """Whether somebody at the terminal types the words; without a terminal nobody does."""
    if not sys.stdin.isatty():
        return False
    typed = click.prompt(f"The output will play. Type '{WORDS}' when no hand is on the surface", default="", err=True)
    return str(typed).strip().casefold() == WORDS
