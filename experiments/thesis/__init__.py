"""Reproduced tables, figures and findings of the thesis.

`items.toml` lists them in the order of the page, with their texts and the functions that compute them.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

from tactometry.config.toml import shipped_table
from tactometry.loading import resolve

if TYPE_CHECKING:
    from .reproduction import Reproduction

_ITEMS: Final[dict[str, dict[str, Any]]] = shipped_table(__package__, "items")
REPRODUCTIONS: Final = tuple(_ITEMS)
"""Names of the items, in the order of the page."""


def reproduction_of(name: str) -> "Reproduction":
    """Return an item by its name."""
    from . import studies
    from .reproduction import Reproduction

    texts_of_item = dict(_ITEMS[name])
    numbers, drawn_in, ranges = (texts_of_item.pop(key, "") for key in ("numbers", "drawn_in", "ranges"))
    module = import_module(f"{__name__}.{drawn_in or numbers.partition(':')[0]}")
    texts_of_item = {"stated": "", "assumes": "{m.ASSUMES}", **texts_of_item}
    texts: dict[str, Any] = {
        key: " ".join(text.format(m=module, studies=studies).split()) for key, text in texts_of_item.items()
    }
    return Reproduction(
        **texts,
        numbers=resolve(f"{__name__}.{numbers}") if numbers else None,
        drawing=module.DRAWN[name.partition("-")[2]] if drawn_in else None,
        ranges=tuple(resolve(f"{__name__}.{ranges}").values()) if ranges else (),
        name=name,
    )
