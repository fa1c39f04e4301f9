"""Every example of the page on time reversal runs, in order, and prints what its comments say."""

import re

from places import DOCS

PAGE = (DOCS / "reference" / "time_reversal.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


def said(example):
    """What follows each print: a comment on its line, or the line below it."""
    return re.findall(r"^print\(.*\)(?:  |\n)# (.+)$", example, re.MULTILINE)


def test_every_example_prints_what_the_page_says(capsys):
    names = {}
    for example in EXAMPLES:
        exec(compile(example, "docs/reference/time_reversal.md", "exec"), names)
        assert capsys.readouterr().out.splitlines() == said(example)


def test_the_page_speaks_of_every_effect():
    effects = (
        "relearn",
        "warmed",
        "contact_is_lost",
        'modulation="burst"',
        "path=",
        "weights=",
        "window=",
        "uniformity",
    )
    others = ("trimmed", "reciprocity_error", "mode_count", "modal_density_s", "point_impedance", "group_velocity")
    assert [name for name in effects + others if name not in "".join(EXAMPLES)] == []
