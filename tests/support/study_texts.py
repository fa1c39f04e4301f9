"""Study files whose text is changed: shorter, faster, on another bench, or so that no study can be made of it."""

import pytest

from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load, parse


def changed(text, changes):
    """The text with all changes, none of which may miss what it replaces."""
    for old, new in changes.items():
        assert old in text, old
        text = text.replace(old, new)
    return text


def tutorial_in(folder, changes):
    """A file with the tutorial, changed."""
    path = folder / "short.toml"
    path.write_text(changed(load("tutorial")[1].decode(), changes), encoding="utf-8")
    return path


def wired(text):
    """The experiment that a text makes."""
    return wire(parse(text.encode(), "s.toml"), "s.toml")


def refusal(text):
    """Why a text makes no experiment."""
    with pytest.raises((InvalidFile, InvalidParameter)) as error:
        wired(text)
    return str(error.value)
