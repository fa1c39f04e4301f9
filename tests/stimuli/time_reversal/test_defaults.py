"""Defaults shared by stimuli, effects, surfaces and the design guide."""

import ast
from collections import defaultdict
from collections.abc import Iterator
from functools import cache

import pytest
from places import ROOT

ROOMS = ("time_reversal", "scenes", "perception")
NEUTRAL = {"None", "0", "0.0", "1", "1.0", "inf", "()", "''", "True", "False"}
"""Nothing, in a field that may be left out."""
TWO_QUANTITIES = {
    "cutoff_hz": "where an amplifier rolls off, and where hearing ends",
    "duration_s": "of what is presented, and of a train in it",
    "envelope": "a shape, and its name in a file",
    "flank_hz": "of the audible filter, and of the band",
    "level_unit": "of any responses in metre, of a study in decibel",
    "modulation": "of the foci of a train, and of a carrier",
    "pattern": "a pattern, and its name in a file",
    "reference_m": "of a focus at threshold, and of the skin",
}
"""Fields of one name whose defaults differ, and why."""


def defaults() -> Iterator[tuple[str, str, ast.expr]]:
    """Field, class and default of every field of the rooms that has one."""
    files = [path for room in ROOMS for path in (ROOT / "stimuli" / room).rglob("*.py")]
    for path in (*files, ROOT / "stimuli" / "hybrid.py"):
        classes = (node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.ClassDef))
        for each in classes:
            for field in each.body:
                if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and field.value:
                    yield field.target.id, each.name, field.value


@cache
def by_name() -> dict[str, dict[str, ast.expr]]:
    found: dict[str, dict[str, ast.expr]] = defaultdict(dict)
    for field, owner, default in defaults():
        classed = "ClassVar" in ast.unparse(default) or isinstance(default, ast.Dict)
        taken = ast.unparse(default).endswith(f".{field}")
        if not (classed or taken) and ast.unparse(default) not in NEUTRAL and "field(" not in ast.unparse(default):
            found[field][owner] = default
    return {field: owners for field, owners in found.items() if len(owners) > 1}


@pytest.mark.parametrize("field", sorted(by_name()))
def test_a_field_of_one_name_has_one_default_from_one_place(field):
    owners = by_name()[field]
    stated = {owner: ast.unparse(default) for owner, default in owners.items()}
    if field in TWO_QUANTITIES:
        assert len(set(stated.values())) > 1, f"one default after all: take it out of TWO_QUANTITIES, {stated}"
        return
    assert len(set(stated.values())) == 1, stated
    assert not any(isinstance(part, ast.Constant) for default in owners.values() for part in ast.walk(default)), stated


def test_two_quantity_names_exist():
    assert set(by_name()) >= set(TWO_QUANTITIES)
