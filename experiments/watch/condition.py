"""What a condition is called on the page."""

from collections.abc import Mapping

from tactometry.analysis.wording import condition_name


def condition_words(factors: Mapping[str, float | str]) -> str:
    """A condition in words; empty without factors.

    >>> condition_words({"frequency_hz": 240.0, "force_n": ""})
    '240 Hz'
    """
    stated = {name: level for name, level in factors.items() if level != ""}
    return condition_name(tuple(stated), tuple(stated.values())) if stated else ""
