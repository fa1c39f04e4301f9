"""The tables of keys as they stand in the docs, and the command that writes them there.

`python -m tactometry.experiments.reference.pages` (`make keys`) writes them.
"""

import re
from collections.abc import Iterable, Mapping
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import Final

from tactometry.rigs.texts import texts_in

from .block import block, holds
from .key_table import KeyTable
from .keys import Key, keys_of
from .meanings import summary
from .tables import PAGES, tables_of_page

BEGIN, END = "<!-- keys: written by `make keys` -->", "<!-- end of keys -->"
ROOT: Final = Path(__file__).resolve().parents[2]
FOLDER: Final = ROOT / "docs" / "reference"


def texts() -> Mapping[str, str]:
    """The messages and labels that `[texts]` may replace, as they are shipped, in the order of their file."""
    shipped = texts_in("en", {})
    return {**shipped.messages, **shipped.labels}


def with_tables(text: str, page: str, behind: str = "") -> str:
    """The text of a page with its tables of keys anew, between the marks."""
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    parts = [_section(alike, page) for alike in _sections(page)]
    return "\n\n".join([f"{before}{BEGIN}", *parts, *filter(None, [behind]), f"{END}{after}"])


def path_of(page: str) -> Path:
    """Where a page is."""
    return FOLDER / f"{page}.md"


def text_of(page: str) -> str:
    """A page that holds keys, as it should be."""
    behind = _texts_in_words() if page == "studies" else ""
    return with_tables(path_of(page).read_text(encoding="utf-8"), page, behind)


def _names(alike: Iterable[KeyTable]) -> str:
    return ", ".join(f"`{table.name}`" for table in alike)


def _slug(heading: str) -> str:
    """The anchor of a heading, as the site and the hosts of repositories make it.

    >>> _slug("`touch.slide`, `touch.press`")
    'touchslide-touchpress'
    """
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def _sections(page: str) -> list[list[KeyTable]]:
    """The tables of a page, those of one class together."""
    tables = tables_of_page(page)
    return [list(alike) for _, alike in groupby(tables, lambda table: (table.reads, table.header))]


@cache
def _places() -> Mapping[str, tuple[str, str]]:
    """Of each table its page and its anchor there."""
    return {table.name: (page, _slug(_names(alike))) for page in PAGES for alike in _sections(page) for table in alike}


def _link(name: str, page: str) -> str:
    """From a page to a table, or to the first below a name."""
    places = _places()
    other, anchor = places.get(name) or next(places[each] for each in places if each.startswith(f"{name}."))
    return f"[`{name}`]({'' if other == page else f'{other}.md'}#{anchor})"


def _section(alike: list[KeyTable], page: str) -> str:
    """Tables of one class: their names, where they stand, their keys, and one of them as a file may hold it."""
    table = alike[0]
    place = f"In `{table.header}`." if table.header else "At the top of the file."
    also = " and ".join(_link(name, page) for name in table.also)
    beside = f"Beside its keys stand those of {also}." if also else ""
    rows = [_row(key, alike, page) for key in keys_of(table)]
    head = ["| key | holds | if left out | meaning |", "|---|---|---|---|"]
    said = " ".join(filter(None, [place, summary(table.reader), *(each.note for each in alike), beside]))
    lines = [f"### {_names(alike)}", "", said, "", *head, *rows]
    return "\n".join([*lines, "", f"<!-- keys: {table.name} -->", "```toml", block(table).rstrip(), "```"])


def _row(key: Key, alike: list[KeyTable], page: str) -> str:
    """A key as a row; a kind of several tables with each of its values."""
    kinds = f"a text, one of {', '.join(table.kind for table in alike)}"
    held = kinds if key.name == "kind" and len(alike) > 1 else holds(key)
    means = "Which kind it is." if key.name == "kind" else key.means
    see = f" Its keys: {_link(key.see, page)}." if key.see else ""
    cells = (f"`{key.name}`", held, _otherwise(key), f"{means}{see}")
    escaped = (cell.replace("|", "\\|") for cell in cells)
    return f"| {' | '.join(escaped)} |"


def _otherwise(key: Key) -> str:
    """What is taken in its place: a value as a file writes it, or that it must be there."""
    in_words = key.required or key.otherwise in ("none", "its own")
    return (key.otherwise or "**required**") if in_words else f"`{key.otherwise}`"


def _texts_in_words() -> str:
    rows = [f"| `{name}` | {' '.join(text.split())} |" for name, text in texts().items()]
    return "\n".join(["### `[texts]`", "", "| name | as shipped |", "|---|---|", *rows])


def main() -> None:
    for page in PAGES:
        path_of(page).write_text(text_of(page), encoding="utf-8")


if __name__ == "__main__":
    main()
