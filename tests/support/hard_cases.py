"""Hard cases of the tests, and docs/explanation/stability.md, which lists them.

A test calls `hard_case` or `exact_case`. Names, references and bounds are literals, which are read from the sources.
`make stability` writes the page from a run of these tests.
"""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from pathlib import Path

import numpy as np
from places import DOCS, ROOT

TESTS = ROOT / "tests"
OWN = TESTS / "whole" / "test_stability.py"
PAGE = DOCS / "explanation" / "stability.md"
ROOMS = {
    "stimuli/time_reversal/": "Time reversal",
    "stimuli/electrovibration/": "Electrovibration",
    "stimuli/perception/": "Perception",
    "stimuli/scenes/": "Scenes",
    "analysis/": "Fits and statistics",
    "kernel/test_psychometric": "Psychometric functions",
    "protocols/test_proc": "Procedures",
    "protocols/test_quest": "Procedures",
    "devices/": "Devices",
    "kernel/test_gates": "Devices",
    "rigs/window/": "Window",
    "kernel/test_limits": "Devices",
    "": "Sessions and data",
}
"""Sections by the first matching beginning of a test file's path."""
HEAD = """# Hard cases

Hard cases of the tests with their reference, the largest error of the run that wrote this page, and the bound that
every run asserts. Errors are relative to the expected size unless the case states otherwise; 0 is equality. `make
stability` writes the page; a test fails if a case is missing, or if an error has grown a hundredfold (and exceeds a
thousandth of its bound). The name of a case is in the source of its test.
"""
DRIFT, MARGIN, ROUNDING = 100.0, 1e-3, 1e-14
"""An error may grow by the factor `DRIFT`, or up to `MARGIN` times its bound, as processors round differently."""
UNSEEN = "-"
SEEN: dict[str, float] = {}


@dataclass(frozen=True)
class Case:
    name: str
    against: str
    bound: float | None
    file: str
    test: str

    @property
    def room(self) -> str:
        return next(room for prefix, room in ROOMS.items() if self.file.startswith(prefix))

    def row(self, error: str) -> str:
        bound = "computed" if self.bound is None else f"{self.bound:.2g}"
        return f"| {self.name} | {self.against} | {error} | {bound} |"


def hard_case(case, found, expected, bound, *, against, floor=0.0):
    """Assert |found - expected| <= bound (|expected| + floor) everywhere, and note the largest such error."""
    del against
    found, expected = np.broadcast_arrays(np.asarray(found), np.asarray(expected))
    away, size = np.abs(found - expected), np.abs(expected) + floor
    error = float(np.max(np.divide(away, size, out=np.where(away == 0, 0.0, np.inf), where=size > 0), initial=0.0))
    assert error <= bound, f"{case}: found an error of {error:.3g}, the bound is {bound:g}"
    before = stated().get(case, np.inf)
    assert error <= max(DRIFT * before, MARGIN * bound, ROUNDING), (
        f"{case}: found an error of {error:.3g} where docs/explanation/stability.md says {before}; run make stability"
    )
    SEEN[case] = max(SEEN.get(case, 0.0), error)


def exact_case(case, *, against):
    """Record that the assertions before it in the test require equality."""
    del against
    SEEN[case] = 0.0


def cases() -> list[Case]:
    """Return all hard cases in the tests' sources, by section and file."""
    found = [case for path in sorted(TESTS.rglob("test_*.py")) if path != OWN for case in _cases_of(path)]
    order = list(dict.fromkeys(ROOMS.values()))
    return sorted(found, key=lambda case: order.index(case.room))


def file_of(path: Path) -> str:
    """Return a test file's path below the folder `tests`, without suffix."""
    return path.relative_to(TESTS).with_suffix("").as_posix()


def _cases_of(path: Path) -> Iterator[Case]:
    source = path.read_text(encoding="utf-8")
    if "_case(" not in source:
        return
    for function in ast.walk(ast.parse(source)):
        if isinstance(function, ast.FunctionDef) and function.name.startswith("test_"):
            for call in ast.walk(function):
                if isinstance(call, ast.Call) and getattr(call.func, "id", "") in ("hard_case", "exact_case"):
                    words = {word.arg: word.value for word in call.keywords}
                    bound = call.args[-1] if call.func.id == "hard_case" else ast.Constant(0.0)
                    name, against = ast.literal_eval(call.args[0]), ast.literal_eval(words["against"])
                    yield Case(name, against, _number(bound), file_of(path), function.name)


def _number(bound: ast.expr) -> float | None:
    return float(ast.literal_eval(bound)) if isinstance(bound, ast.Constant) else None


@cache
def rows() -> dict[str, str]:
    lines = PAGE.read_text(encoding="utf-8").splitlines() if PAGE.exists() else []
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]
    return {cell[0]: cell[2] for cell in cells if cell[0] != "case"}


def page(seen: dict[str, float]) -> str:
    """Return the page with the error of each case, or a dash without one."""
    lines = [HEAD]
    for room, part in groupby(cases(), key=lambda case: case.room):
        lines += [f"## {room}", "", "| case | reference | largest error | bound |", "|---|---|---|---|"]
        lines += [*(case.row(_stated(seen.get(case.name))) for case in part), ""]
    return "\n".join(lines).rstrip() + "\n"


def _stated(error: float | None) -> str:
    return UNSEEN if error is None else f"{error:.1e}" if error else "0"


def stated() -> dict[str, float]:
    return {name: float(error) for name, error in rows().items() if error != UNSEEN}


def only_hard_cases(items):
    wanted = {(case.file, case.test) for case in cases()}
    return [item for item in items if (file_of(item.path), item.originalname) in wanted]


def pytest_addoption(parser):
    parser.addoption(
        "--stability", action="store_true", help="run the hard cases alone, and write docs/explanation/stability.md"
    )


def pytest_sessionfinish(session, exitstatus):
    """Write the page. A case that did not run keeps its stated error."""
    if session.config.getoption("--stability") and exitstatus == 0:
        rows.cache_clear()
        PAGE.write_text(page(stated() | SEEN), encoding="utf-8")
