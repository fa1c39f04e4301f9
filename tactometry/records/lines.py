"""What a line of a journal may hold: a request with its answer, an event, the head of a sitting, or the end."""

from collections.abc import Mapping
from typing import Any, Final, TypeVar

import msgspec

from ..session.answer_rules import flaw
from ..session.request import REQUESTS, Record, Request

T = TypeVar("T")
Entry = tuple[Request[Any], Any]
_KEYS: Final = {
    "request": {"request", "asked", "answer"},
    "event": {"event", "at_s", "timestamp_utc", "facts"},
    "sitting": {"sitting"},
    "end": {"end"},
}
_MAY: Final[Mapping[str, set[str]]] = {"event": {"duration_s"}}
"""Keys that a line may have, too."""


def kind_of_line(value: dict[str, Any]) -> str:
    """What a line behind the first is, by its keys. Raises `msgspec.ValidationError`."""
    kind = next((kind for kind in _KEYS if kind in value), "")
    keys = value.keys() - _MAY.get(kind, set())
    if kind and keys == _KEYS[kind] and value.get("end", "complete") == "complete":
        return kind
    raise msgspec.ValidationError(f"a line of {', '.join(map(repr, value)) or 'nothing'}")


def decode_entry(value: dict[str, Any]) -> Entry:
    """A request and its answer, from their line.

    Raises
    ------
    msgspec.ValidationError
        If they are none, or the answer is none to that request.
    """
    kind = REQUESTS.get(str(value.get("request")))
    if kind is None:
        raise msgspec.ValidationError(f"the request {value.get('request')!r}")
    request = _strictly(value.get("asked"), kind)
    answer: Any = _strictly(value.get("answer"), kind.answer_type)
    wrong = flaw(request, answer)
    if wrong is not None:
        raise msgspec.ValidationError(wrong)
    return request, answer


def _strictly(value: Any, kind: type[T]) -> T:
    """A value as a class; a key that the class does not know is refused, also in the trial of a `Record`."""
    built = msgspec.convert(value, kind)
    _refuse_unknown(value, built)  # msgspec lets a key pass that a dataclass does not know
    if isinstance(built, Record):
        _refuse_unknown(value["trial"], built.trial)
    return built


def _refuse_unknown(table: Mapping[str, object], built: Any) -> None:
    known = built.__dataclass_fields__.keys()
    if not table.keys() <= known:
        raise msgspec.ValidationError(f"the key {min(table.keys() - known)!r}")
