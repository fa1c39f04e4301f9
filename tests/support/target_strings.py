"""Target strings (`tactometry.loading.resolve`) of a module: what it imports when it is asked for."""

import ast
import re
from collections.abc import Mapping

TARGET = re.compile(r"(tactometry(?:\.[\w*]+)+):(\w+)(?:\.\w+)*")


def targets(tree: ast.Module, module: str, package: str) -> set[tuple[str, str]]:
    """Modules and names in the target strings of a file; a part that is only known as it runs is ``*``.

    Read are texts and f-strings, with ``__name__``, ``__package__`` and constants of the file in them.

    >>> source = 'HERE = f"{__package__}.stages"\\nSTAGES = (f"{__name__}:made", f"{HERE}.map:movie")'
    >>> sorted(targets(ast.parse(source), "tactometry.a.b", "tactometry.a"))
    [('tactometry.a.b', 'made'), ('tactometry.a.stages.map', 'movie')]
    """
    known = {"__name__": module, "__package__": package}
    for line in tree.body:
        if isinstance(line, ast.Assign | ast.AnnAssign) and line.value is not None:
            name = line.targets[0] if isinstance(line, ast.Assign) else line.target
            text = text_of(line.value, known)
            if isinstance(name, ast.Name) and text is not None:
                known[name.id] = text
    texts = [text for node in ast.walk(tree) if (text := text_of(node, known))]
    return {(match[1], match[2]) for text in texts if (match := TARGET.fullmatch(text))}


def text_of(node: ast.AST, known: Mapping[str, str]) -> str | None:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    return "".join(_part(part, known) for part in node.values) if isinstance(node, ast.JoinedStr) else None


def _part(part: ast.expr, known: Mapping[str, str]) -> str:
    if isinstance(part, ast.Constant):
        return str(part.value)
    name = part.value if isinstance(part, ast.FormattedValue) else part
    return known.get(name.id, "*") if isinstance(name, ast.Name) else "*"
