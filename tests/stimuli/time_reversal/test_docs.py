"""The page on time reversal: every name in it exists, and every effect has an example."""

import importlib
import re

import pytest
from page_blocks import texts_of
from places import DOCS

PAGE = (DOCS / "reference" / "time_reversal.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| [^|]+ \| (`[^|]+) \| (`[^|]+) \|$", PAGE, re.MULTILINE)


@pytest.mark.parametrize(("names", "modules"), ROWS)
def test_every_name_of_the_table_exists(names, modules):
    found = [
        importlib.import_module(f"tactometry.stimuli.time_reversal.{m}") for m in re.findall(r"`([\w.]+)`", modules)
    ]
    for name in re.findall(r"`([A-Za-z_][\w.]*)`", names):
        inner = name.partition(".")[2]
        assert any(_has(module, name) or (inner and _has(module, inner)) for module in found), name


def _has(module: object, dotted: str) -> bool:
    for part in dotted.split("."):
        if not hasattr(module, part):
            return False
        module = getattr(module, part)
    return True


def test_the_page_speaks_of_every_effect():
    examples = "".join(texts_of("reference/time_reversal.md", "python"))
    effects = ("relearn", "warmed", 'modulation="burst"', "path=", "weights=", "window=", "uniformity")
    others = ("trimmed", "reciprocity_error", "modal_density_s", "point_impedance", "group_velocity")
    assert [name for name in effects + others if name not in examples] == []
