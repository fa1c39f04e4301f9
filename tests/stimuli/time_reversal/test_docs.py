"""The page on time reversal: its example runs, and every name in it exists."""

import importlib
import re

import pytest
from places import DOCS

PAGE = (DOCS / "reference" / "time_reversal.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| [^|]+ \| (`[^|]+) \| (`[^|]+) \|$", PAGE, re.MULTILINE)


def test_the_example_prints_what_the_page_says(capsys):
    example = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert example is not None
    exec(compile(example[1], "docs/reference/time_reversal.md", "exec"), {})
    said = re.search(r"# ([0-9.]+ um)$", example[1], re.MULTILINE)
    assert said is not None
    assert capsys.readouterr().out.strip() == said[1]


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
