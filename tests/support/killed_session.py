"""Child process of the kill tests: the command line on pipes."""

import os
import sys


def main(arguments, terminal=None):
    """Run `tactometry ARGUMENTS`; `terminal` names the pipes that stand for its input and output."""
    source, output = terminal or (os.devnull, os.devnull)
    sys.stdin = open(source, encoding="utf-8")  # noqa: PTH123, SIM115
    sys.stdout = open(output, "w", encoding="utf-8", buffering=1)  # noqa: PTH123, SIM115
    sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115
    from tactometry.cli import main

    main(list(arguments))


if "CALL" in globals():
    main(*globals()["CALL"])
