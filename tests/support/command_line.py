"""A command line run within the process of the tests."""

import pytest

from tactometry.cli import main


def call(capsys, *arguments):
    """The exit status of a command line and what it said on standard error."""
    with pytest.raises(SystemExit) as ended:
        main(list(map(str, arguments)))
    said = capsys.readouterr()
    return ended.value.code, said.err.strip(), said.out
