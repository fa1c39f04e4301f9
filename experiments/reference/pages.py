"""Tables of keys in the documentation, and the command that writes them and the page of sources.

`python -m tactometry.experiments.reference.pages` (`make keys`) writes them.
"""

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import Final

from . import sources
from .keys import Key, example, holds, keys_of, summary
from .tables import PAGES, KeyTable, tables_of_page

BEGIN, END = "<!-- keys: written by `make keys` -->", "<!-- end of keys -->"
ROOT: Final = Path(__file__).resolve().parents[2]
FOLDER: Final = ROOT / "docs" / "reference"
HEAD: Final = ("| key | holds | if left out | meaning |", "|---|---|---|---|")
FEWEST_SHARED: Final = 2
"""Smallest number of rows equal to those of an earlier table that a link replaces."""
Shown = dict[str, str]
"""Rows of a page, with the first table that contains each."""


def with_tables(text: str, page: str) -> str:
    """Return the text of a page, with updated tables between the marks."""
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    shown: Shown = {}
    parts = [_section(alike, page, shown) for alike in _sections(page)]
    return "\n\n".join([f"{before}{BEGIN}", *parts, f"{END}{after}"])


def path_of(page: str) -> Path:
    """Return the path of a page."""
    return FOLDER / f"{page}.md"


def text_of(page: str) -> str:
    """Return a page with its tables of keys up to date."""
    return with_tables(path_of(page).read_text(encoding="utf-8"), page)


def _names(alike: Iterable[KeyTable]) -> str:
    return ", ".join(f"`{table.name}`" for table in alike)


def _slug(heading: str) -> str:
    """Return the anchor of a heading, as on the website and on GitHub.

    >>> _slug("`touch.slide`, `touch.press`")
    'touchslide-touchpress'
    """
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def _sections(page: str) -> list[list[KeyTable]]:
    tables = tables_of_page(page)
    return [list(alike) for _, alike in groupby(tables, lambda table: (table.reads, table.header))]


@cache
def _places() -> Mapping[str, tuple[str, str]]:
    """Return the page and anchor of each table by its name."""
    return {table.name: (page, _slug(_names(alike))) for page in PAGES for alike in _sections(page) for table in alike}


def _link(name: str, page: str) -> str:
    """Return a link from a page to a table, or to the first one below a name."""
    places = _places()
    other, anchor = places.get(name) or next(places[each] for each in places if each.startswith(f"{name}."))
    return f"[`{name}`]({'' if other == page else f'{other}.md'}#{anchor})"


def _section(alike: list[KeyTable], page: str, shown: Shown) -> str:
    """Return the section of one class: names, location, keys, and an example."""
    table = alike[0]
    place = f"In `{table.header}`." if table.header else "At the top of the file."
    also = " and ".join(_link(name, page) for name in table.also)
    beside = f"The keys of {also} are allowed too." if also else ""
    introduction = " ".join(filter(None, [place, summary(table.reader), *(each.note for each in alike), beside]))

    rows = {key.name: _row(key, alike, page) for key in keys_of(table)}
    known = {name: shown[row] for name, row in rows.items() if row in shown}
    shared = [earlier for earlier, n in Counter(known.values()).items() if n >= FEWEST_SHARED]
    new = [row for name, row in rows.items() if known.get(name) not in shared]
    same = [_shared(earlier, [name for name in rows if known.get(name) == earlier], page) for earlier in shared]
    for row in rows.values():
        shown.setdefault(row, table.name)

    lines = [f"### {_names(alike)}", "", introduction, ""]
    lines += [*HEAD, *new, ""] if new else []
    return "\n".join([*lines, *same, f"<!-- keys: {table.name} -->", "```toml", example(table).rstrip(), "```"])


def _shared(earlier: str, names: list[str], page: str) -> str:
    listed = ", ".join(f"`{name}`" for name in names)
    return f"As in {_link(earlier, page)}: {listed}.\n"


def _row(key: Key, alike: list[KeyTable], page: str) -> str:
    """Return the row of a key. Lists the kinds if there are several."""
    kinds = f"a text, one of {', '.join(table.kind for table in alike)}"
    held = kinds if key.name == "kind" and len(alike) > 1 else holds(key)
    means = "Which kind it is." if key.name == "kind" else key.means
    see = f" Its keys: {_link(key.see, page)}." if key.see else ""
    cells = (f"`{key.name}`", held, _otherwise(key), f"{means}{see}")
    escaped = (cell.replace("|", "\\|") for cell in cells)
    return f"| {' | '.join(escaped)} |"


def _otherwise(key: Key) -> str:
    in_words = key.required or key.otherwise in ("none", "its own")
    return (key.otherwise or "**required**") if in_words else f"`{key.otherwise}`"


def main() -> None:
    for page in PAGES:
        path_of(page).write_text(text_of(page), encoding="utf-8")
    sources.PAGE.write_text(sources.text(), encoding="utf-8")


if __name__ == "__main__":
    main()
