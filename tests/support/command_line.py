"""A command line run within the process of the tests."""

import pytest

from tactometry.cli import main


def status(*arguments):
    """The exit status of a command line."""
    with pytest.raises(SystemExit) as ended:
        main(list(map(str, arguments)))
    return ended.value.code


def call(capsys, *arguments):
    """The exit status of a command line, what it said on standard error, and its output."""
    code = status(*arguments)
    said = capsys.readouterr()
    return code, said.err.strip(), said.out


def output(capsys, *arguments):
    """The output of a command line that succeeds."""
    code, said, out = call(capsys, *arguments)
    assert code == 0, said
    return out


def refused(capsys, *arguments):
    """The one sentence with which a command line is refused."""
    code, said, _ = call(capsys, *arguments)
    assert (code, said.count("\n")) == (2, 0), said
    return said


def assert_one_sentence(said):
    assert said.startswith("tactometry: ")
    assert "\n" not in said
    assert "Traceback" not in said
