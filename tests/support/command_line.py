"""Command lines that run within the test process."""

import io

import pytest

from tactometry.cli import main


def status(*arguments):
    with pytest.raises(SystemExit) as ended:
        main(list(map(str, arguments)))
    return ended.value.code


def call(capsys, *arguments):
    """Return exit status, standard error and output of a command line."""
    code = status(*arguments)
    said = capsys.readouterr()
    return code, said.err.strip(), said.out


def at_the_console(capsys, monkeypatch, study, out, answers, *more):
    """Call a console session in which these lines are typed."""
    monkeypatch.setattr("sys.stdin", io.StringIO(answers))
    return call(capsys, "run", study, "--participant", "P01", "--rig", "console", "--out", out, *more)


def output(capsys, *arguments):
    code, said, out = call(capsys, *arguments)
    assert code == 0, said
    return out


def refused(capsys, *arguments):
    """Return the error message of a refused command line."""
    code, said, _ = call(capsys, *arguments)
    assert (code, said.count("\n")) == (2, 0), said
    return said


def assert_one_sentence(said):
    assert said.startswith("tactometry: ")
    assert "\n" not in said
    assert "Traceback" not in said
