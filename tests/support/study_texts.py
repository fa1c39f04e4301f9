"""Study texts with changes: shorter, on another bench, or invalid."""

import pytest

from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load, parse

CONSTANT = (
    'kind = "constant_stimuli"\nlevels = [22, 28, 34, 40]                       # dB re 1 V peak\nrepeats = 4\n\n'
)


def changed(text, changes):
    """Apply text replacements; each must match."""
    for old, new in changes.items():
        assert old in text, old
        text = text.replace(old, new)
    return text


def with_constant_stimuli(text):
    """Return the tutorial with four levels of up to 100 V instead of its staircase."""
    before, kind, rest = text.partition('kind = "staircase"')
    assert kind
    return f"{before}{CONSTANT}{rest[rest.index('[limits]') :].replace('200.0', '100.0')}"


TUTORIAL = with_constant_stimuli(load("tutorial")[1].decode())


def tutorial_in(folder, changes):
    path = folder / "short.toml"
    path.write_text(changed(TUTORIAL, changes), encoding="utf-8")
    return path


def wired(text):
    return wire(parse(text.encode(), "s.toml"), "s.toml")


def refusal(text):
    with pytest.raises((InvalidFile, InvalidParameter)) as error:
        wired(text)
    return str(error.value)
