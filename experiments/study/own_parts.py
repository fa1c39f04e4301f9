"""Custom stimulus and sensation classes, from a file next to the study."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, make_dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from tactometry.arguments.require import expect
from tactometry.contact import Contact
from tactometry.signal import Signal
from tactometry.user_code import REMEDY, Expected, class_beside, guarded, not_allowed

STATED: Final = ("duration_s", "level_unit")
"""Keys of a custom stimulus that the study must state, so that its data can be read without the code."""


def _is_level(value: object) -> bool:
    return isinstance(value, int | float | np.integer | np.floating) and bool(value < np.inf)


def _plain_signal(signal: Signal) -> Signal:
    """Convert a signal of a subclass to a checked `Signal`."""
    return signal if type(signal) is Signal else Signal(signal.samples, signal.rate_hz, signal.unit)


CALLS: Final = {
    "at": Expected("a Signal (tactometry.signal)", lambda value, _: isinstance(value, Signal), _plain_signal),
    "sensation_db": Expected("a number in dB, or -inf if nothing is felt", lambda value, _: _is_level(value), float),
    "__post_init__": None,
}
"""Methods whose results are checked, and the expected results."""


@dataclass(frozen=True)
class OwnStimulus:
    """Custom stimulus of a class ``module:Class``, with checked signals."""

    made: Any
    target: str

    @property
    def duration_s(self) -> float:
        return float(self.made.duration_s)

    @property
    def read(self) -> bool:
        """True if the code of the class may run."""
        return not isinstance(self.made, Unseen)

    @property
    def level_unit(self) -> str:
        return str(self.made.level_unit)

    def at(self, level: float) -> Signal:
        """Return the signal at a level. Checks its unit (V) and its duration."""
        signal: Signal = self.made.at(level)
        where = f"{self.target}.at({level:g})"
        expect(
            signal.unit == "V",
            where,
            f"a signal in {signal.unit!r}",
            f"the voltage at the load, in 'V'; {REMEDY}",
        )
        as_long = abs(signal.duration_s - self.duration_s) < 1.5 / signal.rate_hz
        stated = f"{self.duration_s:g} s, as stated by its duration_s; {REMEDY}"
        expect(as_long, where, f"a signal of {signal.duration_s:g} s", stated)
        return signal


class Unseen:
    """Placeholder for a class whose code must not run, to read existing data."""

    target: str
    where: str

    def at(self, level: float) -> Signal:
        """Raise `InvalidParameter`."""
        del level
        raise not_allowed(self.where, self.target, "a stimulus")

    def sensation_db(self, signal: Signal, contact: Contact) -> float:
        del signal, contact
        raise not_allowed(self.where, self.target, "a sensation model")


def stimulus_class(
    table: Mapping[str, Any],
    factors: Collection[str],
    of_touch: Collection[str],
    code_from: Path | None,
    *,
    plays: bool,
) -> Any:
    """Return the class of `[stimulus]`, or a placeholder if `plays` is False.

    Raises `InvalidParameter` if the class does not exist, lacks a required member, or its code is not allowed.

    - `factors`: Factors that are keys of the stimulus.
    - `of_touch`: Keys of the touch.
    """
    target, where = table["kind"], "stimulus.kind"
    for name in STATED:
        expected = f"{name} = ... in [stimulus], as data are read without the code of {target!r}"
        expect(name in table or name in factors, f"stimulus.{name}", "no such key", expected)
    if not plays:
        return _unseen(target, where, [*table, *factors])
    if code_from is None:
        raise not_allowed(where, target, "a stimulus")
    kind = class_beside(target, code_from, where)
    fields = getattr(kind, "__dataclass_fields__", {})
    lacking = [*(name for name in STATED if name not in fields), *([] if hasattr(kind, "at") else ["at(level)"])]
    expect(not lacking, where, f"{target!r}, which lacks {', '.join(lacking)}", "a class that has them")
    both = [name for name in of_touch if name in fields and name not in STATED]
    expect(not both, where, f"{target!r} with the field {', '.join(both)}, a key of the touch", "another name for it")
    return guarded(kind, CALLS)


def sensation_class(table: Mapping[str, Any], code_from: Path | None) -> Any:
    """Return the class of `[sensation]`, or a placeholder without `code_from`.

    Raises `InvalidParameter` if the class does not exist or has no `sensation_db`.
    """
    target, where = table["kind"], "sensation.kind"
    if code_from is None:
        return _unseen(target, where, [*table])
    kind = class_beside(target, code_from, where)
    expect(
        hasattr(kind, "sensation_db"),
        where,
        f"{target!r}, which lacks sensation_db(signal, contact)",
        "a class that has it",
    )
    return guarded(kind, CALLS)


def _unseen(target: str, where: str, keys: Collection[str]) -> Any:
    fields = [(key, Any) for key in dict.fromkeys(keys) if key != "kind"]
    return make_dataclass("Unseen", fields, bases=(Unseen,), frozen=True, namespace={"target": target, "where": where})
