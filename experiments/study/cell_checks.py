"""Checks of all cells of a study: their places, and the guess rates of their rules."""

from collections import defaultdict
from collections.abc import Iterable, Mapping

from tactometry.arguments.require import expect
from tactometry.errors import count_of
from tactometry.protocols.tasks.task import Place

from .cells import WiredCell, tables
from .procedure_table import check_guess_rates
from .session_plan import Key, places_of
from .study import Study


def check_rules(study: Study, cells: Iterable[WiredCell]) -> None:
    """Refuse rules whose guess rate contradicts the task (`check_guess_rates`)."""
    for cell in cells:
        check_guess_rates(tables(study, cell.condition.factors)["procedure"], study.task)


def check_places(over: str | None, cells: Mapping[Key, WiredCell]) -> None:
    """Refuse alternatives of a trial that share a place, if they are at places at all."""
    together: dict[Key, list[frozenset[Place]]] = defaultdict(list)
    for key, cell in cells.items():
        rest = tuple(item for item in key if item[0] != over)
        together[rest].extend(filter(None, [frozenset(places_of(cell.stimulus))]))
    for alternatives in together.values() if over else ():
        n, n_apart = len(alternatives), len(set(alternatives))
        found = f"{n} alternatives of {over!r} at {count_of(n_apart, 'place')}"
        expect(n == n_apart, "task.over", found, "no more answers than places; give each a place of its own")
