"""Limits on the length of functions, files and class names of the project."""

import ast
from collections import defaultdict
from collections.abc import Iterator
from functools import cache

from source_tree import name_of, parsed, sources

FUNCTION_LINES, FILE_LINES = 40, 400
POSITIONAL = 7


def docstring_lines(function: ast.FunctionDef) -> set[int]:
    if ast.get_docstring(function, clean=False) is None:
        return set()
    return set(range(function.body[0].lineno, (function.body[0].end_lineno or 0) + 1))


def functions(tree: ast.Module) -> list[ast.FunctionDef]:
    return [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]


def code_sizes(tree: ast.Module, source: str) -> Iterator[tuple[str, int]]:
    """Yield functions with their lines without docstring and comments."""
    lines = source.splitlines()
    full = {n for n, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")}
    for node in functions(tree):
        body = full.intersection(range(node.lineno, (node.end_lineno or 0) + 1))
        yield node.name, len(body - docstring_lines(node))


def positional(function: ast.FunctionDef) -> int:
    names = [arg.arg for arg in (*function.args.posonlyargs, *function.args.args)]
    return len(names) - (names[:1] in (["self"], ["cls"]))


@cache
def sizes() -> list[tuple[str, int]]:
    return [
        (f"{name_of(path)}: {name}", size)
        for path in sources()
        for name, size in code_sizes(parsed(path), path.read_text(encoding="utf-8"))
    ]


def names_in_two_modules(trees: dict[str, ast.Module]) -> dict[str, list[str]]:
    """Return class names that several modules define, with the modules."""
    modules = defaultdict(set)
    for module, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                modules[node.name].add(module)
    return {name: sorted(places) for name, places in modules.items() if len(places) > 1}


def test_docstring_blanks_and_comments_are_not_code() -> None:
    source = 'def f(x):\n    """Twice.\n\n    Of x.\n    """\n\n    # so\n    y = x\n    return 2 * y\n'
    assert list(code_sizes(ast.parse(source), source)) == [("f", 3)]


def test_parameter_count_excludes_self() -> None:
    source = "class A:\n    def f(self, x, /, y, *more, z): ...\ndef f(x, /, y=0): ..."
    assert [positional(function) for function in functions(ast.parse(source))] == [2, 2]


def test_a_class_in_two_modules_is_found() -> None:
    source = {"a": "class A: ...\nclass B: ...", "b": "def f():\n    class A: ...", "c": "class C: ..."}
    assert names_in_two_modules({name: ast.parse(text) for name, text in source.items()}) == {"A": ["a", "b"]}


def test_no_function_is_long() -> None:
    assert {name: size for name, size in sizes() if size > FUNCTION_LINES} == {}


def test_no_function_takes_many_parameters_by_place() -> None:
    many = [
        f"{name_of(path)}: {function.name}"
        for path in sources()
        for function in functions(parsed(path))
        if positional(function) > POSITIONAL
    ]
    assert many == [], "give some by name alone, or make a value of them"


def test_class_names_are_unique() -> None:
    assert names_in_two_modules({name_of(path): parsed(path) for path in sources()}) == {}


def test_a_file_has_one_subject_and_stays_short() -> None:
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in sources()}
    assert {name_of(path): n for path, n in lines.items() if n > FILE_LINES} == {}
