"""The page of all that is made anew: what is derived, and what it agrees with."""

from collections import Counter
from collections.abc import Iterator, Sequence

from .captions import BESIDE, NOT_MADE
from .reproduction import Number, Reproduced

HEAD = """# What of the thesis comes out

<!-- not run: all of it takes minutes; tests/experiments/test_reproductions.py makes each -->
```console
$ tactometry reproduce all --out reproduced           # CSV of every table and finding, CSV and PNG of every figure
$ tactometry reproduce table-4.3 --out reproduced
$ tactometry reproduce all --page docs/explanation/reproduced.md  # this page
```

The thesis is H. Zophoniasson's (2017). Our sources hold its front matter, lists of figures and tables, abstract and
pages 17 to 39; what they state stands beside each item, with its page. Most values of its tables are not among it, so
that most numbers here can be compared with nothing. Each number is

- **derived** (d): it comes out of the physics, given the input that is said to be assumed,
- **calibrated** (c): one constant was set to it, or to what it is proportional to,
- **assumed** (a): the input says so.

Four constants of the models are set to what the thesis states: the resistance of a finger at 2 N and the attenuation
constant tau (together, to 30 % and 6 %, finding-2), the moment per volt of a patch (so that one bit at 30 V gives
10 um), and the amplitude of a focus at threshold (10 um, finding-1). What is set or proportional to them is calibrated;
what hangs on them otherwise is derived, given them. What comes of an input that was chosen for it (a carrier in
finding-3) is assumed.

In the tables ✓ agrees with what is stated and ✗ does not; of what our sources hold nothing there is no mark.
Only a derived number that agrees with what is stated counts as *reproduced*. This page is made by the command;
nobody writes in it.
"""
SCORE_HEAD = ("| item | quantity | condition | found | how | stated | verdict |", "|---|---|---|---|---|---|---|")


def page(made: Sequence[Reproduced]) -> str:
    """The text of the page, of items in their order; a drawing is named without its curves."""
    sections = (line for each in made for line in _section(each))
    return "\n".join([HEAD, *_score(made), *_left_out(), *sections]) + "\n"


def verdict(number: Number) -> str:
    """What a number is worth beside what is stated."""
    if number.holds is None:
        return "not compared"
    if number.is_reproduced:
        return "**reproduced**"
    return f"agrees, as {number.origin}" if number.holds else "does not agree"


def count_verdicts(made: Sequence[Reproduced]) -> Counter[str]:
    """How many of the numbers that something is stated of have each verdict."""
    return Counter(verdict(number) for each in made for number in each.compared)


def show(value: float) -> str:
    """Three digits, and no exponent where none is needed.

    >>> show(0.012345), show(1490.2), show(-0.0)
    ('0.0123', '1490', '0')
    """
    digits = f"{value:.0f}" if 1000 <= abs(value) < 1e6 else f"{value:.3g}"
    return digits.removeprefix("-") if float(digits) == 0 else digits


def _score(made: Sequence[Reproduced]) -> Iterator[str]:
    counts = count_verdicts(made)
    yield "## What is stated, and what comes out\n"
    yield f"{', '.join(f'{words}: {n}' for words, n in sorted(counts.items()))}.\n"
    yield from SCORE_HEAD
    for reproduced in made:
        name = reproduced.item.name
        for number in reproduced.compared:
            value = f"{show(number.value)} {number.unit}".strip()
            cells = (f"[{name}](#{_anchor(name)})", number.quantity, number.condition, value, number.origin)
            yield f"| {' | '.join((*cells, number.stated, verdict(number)))} |"
    yield ""


def _left_out() -> Iterator[str]:
    """The captions that have no item of their own."""
    yield "## Captions without an item of their own\n"
    yield "| made beside another | by |"
    yield "|---|---|"
    for item, captions in BESIDE.items():
        yield f"| {', '.join(captions)} | [{item}](#{_anchor(item)}) |"
    yield "\n| not made | why |"
    yield "|---|---|"
    for reason, captions in NOT_MADE.items():
        yield f"| {', '.join(captions)} | {reason} |"
    yield ""


def _anchor(name: str) -> str:
    return name.replace(".", "").lower()


def _section(reproduced: Reproduced) -> Iterator[str]:
    item = reproduced.item
    yield f"## {item.name}\n"
    yield f"{item.title}.\n"
    yield f"*Stated:* {item.stated}\n"
    yield f"*Assumed:* {item.assumes}\n"
    if item.outcome:
        yield f"*Outcome:* {item.outcome}\n"
    if item.drawing is not None:
        yield f"*Figure:* {item.name}.png, its curves in {item.name}.csv; {item.origin}.\n"
    if reproduced.numbers:
        yield from _table(reproduced.numbers)
        yield ""


def _cell(number: Number) -> str:
    mark = {None: "", True: " ✓", False: " ✗"}[number.holds]
    return f"{show(number.value)} {number.origin[0]}{mark}"


def _table(numbers: Sequence[Number]) -> Iterator[str]:
    """A row per condition, a column per quantity, each number with the letter of its origin."""
    quantities = {number.quantity: number.unit for number in numbers}
    cells = {(number.condition, number.quantity): _cell(number) for number in numbers}
    yield f"| | {' | '.join(f'{name} ({unit})' if unit else name for name, unit in quantities.items())} |"
    yield f"|---|{'---|' * len(quantities)}"
    for condition in dict.fromkeys(number.condition for number in numbers):
        yield f"| {condition} | {' | '.join(cells.get((condition, name), '') for name in quantities)} |"
