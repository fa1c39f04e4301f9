"""Render the HTML of the page and its sections."""

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from . import view
from .watcher import Drawn, Sight

if TYPE_CHECKING:
    from jinja2 import Template

SECTIONS: Final = ("title", "alerts", "where", "levels", "curve", "touch", "touches", "quality", "conditions")
"""Templates of the sections that change, by the names of their elements."""


@cache
def _template() -> "Template":
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    files = FileSystemLoader(Path(__file__).parent)
    environment = Environment(
        loader=files, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    parts: Any = environment.get_template("parts.html").module
    environment.globals |= {"plot": parts.plot, "named": parts.named}
    return environment.get_template("page.html")


def _values(sight: Sight, drawn: Drawn) -> dict[str, Any]:
    return {"view": view, "sight": sight, "progress": sight.progress, "drawn": drawn}


def page(sight: Sight, drawn: Drawn) -> str:
    """Return the HTML of the whole page."""
    return _template().render(_values(sight, drawn))


def sections(sight: Sight, drawn: Drawn) -> dict[str, str]:
    """Return the HTML of each section.

    >>> sections(Sight(), Drawn())["levels"].split()
    ['<h2>Levels</h2>', '<p>No', 'trial', 'yet.</p>']
    """
    template, values = _template(), _values(sight, drawn)
    return {name: "".join(template.blocks[name](template.new_context(values))) for name in SECTIONS}
