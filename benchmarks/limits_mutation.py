"""Mutation testing of limits, loads, guard and ledger. Each single change of the code must fail a test.

Run: python benchmarks/limits_mutation.py
"""

import ast
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from tactometry.experiments.harness import tell

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("tactometry", "stimuli", "protocols", "analysis", "experiments", "tests")
LIMITS, LOAD, EXPOSURE, FILTERED = (
    f"tests/kernel/test_{name}.py" for name in ("limits", "load", "exposure", "filtered_limits")
)
LEDGER, GUARD, OUTPUTS, PLAYED = (
    f"tests/devices/test_{name}.py" for name in ("ledger", "guarded", "outputs", "filtered_outputs")
)
STOP = "tests/experiments/test_stop_delay.py"
TESTS = {
    "tactometry/safety/limits.py": (LIMITS, FILTERED, EXPOSURE),
    "tactometry/safety/load.py": (LOAD, LIMITS, FILTERED, EXPOSURE),
    "tactometry/devices/outputs/guarded.py": (GUARD, PLAYED, EXPOSURE, LEDGER, OUTPUTS, STOP),
    "tactometry/devices/outputs/emission_ledger.py": (LEDGER, GUARD),
}
"""Tests of each module, except those that require a display."""
PREPENDED = "signed, absolute = (np.diff(course, axis=1, prepend=0.0) for course in (self.passed_c, self.absolute_c))"
INSIDE = "inside = (slope != 0) & ((turning_v - before) * (turning_v - after) < 0)"
SEARCHED = "_check(name, what, peak(limit * (1 + TOLERANCE)), limit, unit, cure, TOLERANCE)"
EQUAL = {
    f"{PREPENDED}: 0.0 -> 1.0": "the prepended value cancels",
    f"{INSIDE}: 0 -> 1": "a level piece does not cross another voltage",
    "self._final = functools.lru_cache(maxsize=1)(self._keep_to_limits): 1 -> 2": "the cached value is the same",
    f"{SEARCHED}: limit * (1 + TOLERANCE) -> limit / (1 + TOLERANCE)": "a lower bound only makes the search longer",
    f"{SEARCHED}: 1 + TOLERANCE -> 1 - TOLERANCE": "a lower bound only makes the search longer",
    "LONGEST_WAIT_S: Final = 1.0: 1.0 -> 2.0": "time to wait for another process",
    "self._last = (added.lastrowid or 0, now, duration_s): 0 -> 1": "an added row has a number",
    "database.execute(\"PRAGMA synchronous = OFF\"): database.execute('PRAGMA synchronous = OFF') -> pass": "speed",
    "if self.driver.n_gaps(0.0):: 0.0 -> 1.0": "time to wait for an answer",
}
"""Changes without an observable effect, and the reason."""
SWAPS: dict[type[ast.AST], Any] = {
    ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
NAMES = {"min": "max", "max": "min", "floor": "ceil", "ceil": "floor", "minimum": "maximum", "maximum": "minimum"}


def changed(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the mutated forms of one node of a syntax tree."""
    match node:
        case ast.Compare(left=left, ops=[op], comparators=others) if type(op) in SWAPS:
            yield ast.Compare(left, [SWAPS[type(op)]()], others)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in SWAPS:
            yield ast.BinOp(left, SWAPS[type(op)](), right)
        case ast.BoolOp(op=op, values=values):
            yield ast.BoolOp(SWAPS[type(op)](), values)
        case ast.Expr(value=ast.Call()):
            yield ast.Pass()
        case ast.Name(id=name, ctx=context) if name in NAMES:
            yield ast.Name(NAMES[name], context)
        case ast.Attribute(value=value, attr=name, ctx=context) if name in NAMES:
            yield ast.Attribute(value, NAMES[name], context)
        case ast.Constant(value=bool() as value):
            yield ast.Constant(not value)
        case ast.Constant(value=int() | float() as value):
            yield ast.Constant(value + 1)
        case ast.Tuple(elts=elements, ctx=context) if all(isinstance(one, ast.Constant) for one in elements):
            yield from (ast.Tuple(elements[:n] + elements[n + 1 :], context) for n in range(len(elements)))


def fields(node: ast.AST) -> Iterator[tuple[Any, Any, ast.AST]]:
    """Yield container, place and child of each node below one, except error texts and types."""
    for name, value in ast.iter_fields(node):
        if name in {"annotation", "returns", "decorator_list"} or isinstance(node, ast.Raise | ast.JoinedStr):
            continue
        children = enumerate(value) if isinstance(value, list) else [(name, value)]
        for place, child in children:
            if isinstance(child, ast.AST):
                yield value if isinstance(value, list) else vars(node), place, child
                yield from fields(child)


def mutants(source: str) -> list[tuple[str, str]]:
    """Return a description of each change, and the changed source."""
    tree, lines, result = ast.parse(source), source.splitlines(), []
    for container, place, node in fields(tree):
        for form in changed(node):
            container[place] = form
            change = f"{lines[getattr(node, 'lineno', 0) - 1].strip()}: {ast.unparse(node)} -> {ast.unparse(form)}"
            result.append((change, ast.unparse(tree)))
            container[place] = node
    return result


def is_killed(tree: Path, module: str, source: str) -> bool:
    """Return True if a test of a module fails with the changed source, in a copy of the project."""
    kept = (tree / module).read_text(encoding="utf-8")
    (tree / module).write_text(source, encoding="utf-8")
    options = ("-q", "-x", "-p", "no:cacheprovider", "--hypothesis-profile", "once", "--timeout", "60")
    command = [sys.executable, "-m", "pytest", *options, "-k", "not across_sittings", *TESTS[module]]
    env = {**os.environ, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        return subprocess.run(command, cwd=tree, env=env, capture_output=True, check=False).returncode != 0
    finally:
        (tree / module).write_text(kept, encoding="utf-8")


def survivors(module: str, trees: "SimpleQueue[Path]") -> tuple[int, list[str]]:
    """Return the number of a module's mutants, and those that no test detects."""
    source = (ROOT / module).read_text(encoding="utf-8")

    def tried(mutant: str) -> bool:
        tree = trees.get()
        try:
            return is_killed(tree, module, mutant)
        finally:
            trees.put(tree)

    assert not tried(source), f"{module}: its tests fail without a change"
    made = [(what, mutant) for what, mutant in mutants(source) if what not in EQUAL]
    with ThreadPoolExecutor(trees.qsize()) as pool:
        killed = list(pool.map(tried, [mutant for _, mutant in made]))
    return len(made), [what for (what, _), is_noticed in zip(made, killed, strict=True) if not is_noticed]


def main(modules: list[str]) -> None:
    trees: SimpleQueue[Path] = SimpleQueue()
    with tempfile.TemporaryDirectory() as folder:
        for n in range(os.cpu_count() or 1):
            tree = Path(folder) / str(n)
            for name in FOLDERS:
                shutil.copytree(ROOT / name, tree / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
            shutil.copy(ROOT / "pyproject.toml", tree)
            trees.put(tree)
        for module in modules:
            n_made, left = survivors(module, trees)
            for what in left:
                print(f"SURVIVED {module}, {what}", flush=True)
            tell(f"of {n_made} mutants of {Path(module).name}, killed", n_made - len(left), "mutants", at_least=n_made)


if __name__ == "__main__":
    main(sys.argv[1:] or list(TESTS))
