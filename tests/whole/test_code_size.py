"""Small functions, short files: the numbers that the project holds itself to."""

import ast
import statistics
from pathlib import Path

import pytest
from places import ROOT

ROOMS = ("tactometry", "stimuli", "protocols", "analysis", "experiments")
FUNCTION_MEDIAN, FUNCTION_90TH_PERCENTILE, FILE_LINES = 5, 20, 400


def sources() -> list[Path]:
    found = (path for room in ROOMS for path in (ROOT / room).rglob("*.py"))
    return sorted(path for path in found if not any(part.is_symlink() for part in (path, *path.parents)))


def docstring_lines(function: ast.FunctionDef) -> set[int]:
    if ast.get_docstring(function, clean=False) is None:
        return set()
    return set(range(function.body[0].lineno, (function.body[0].end_lineno or 0) + 1))


def code_sizes(source: str) -> list[int]:
    """Lines of each function without docstring, blanks and comments."""
    lines = source.splitlines()
    full = {n for n, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")}
    functions = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.FunctionDef)]
    return [
        len(full.intersection(range(node.lineno, (node.end_lineno or 0) + 1)) - docstring_lines(node))
        for node in functions
    ]


def test_docstring_blanks_and_comments_are_not_code() -> None:
    source = 'def f(x):\n    """Twice.\n\n    Of x.\n    """\n\n    # so\n    y = x\n    return 2 * y\n'
    assert code_sizes(source) == [3]


def test_functions_stay_small() -> None:
    sizes = [size for path in sources() for size in code_sizes(path.read_text(encoding="utf-8"))]
    assert statistics.median(sizes) <= FUNCTION_MEDIAN
    assert statistics.quantiles(sizes, n=10)[-1] <= FUNCTION_90TH_PERCENTILE


@pytest.mark.parametrize("path", sources(), ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_file_has_one_subject_and_stays_short(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= FILE_LINES
