"""The repository's files, and copies that a test may modify."""

import ast
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

from places import ROOT

WINGS = ("stimuli", "protocols", "analysis", "experiments")
"""Folders next to the kernel, which links to each for editors and type checkers."""
FOLDERS = ("tactometry", *WINGS)


def sources() -> list[Path]:
    paths = (path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py"))
    return sorted(path for path in paths if not any(part.is_symlink() for part in (path, *path.parents)))


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def copy_tree(place: Path, *files: str) -> Path:
    """Copy the product's folders and these files; return `place`."""
    for file in files:
        shutil.copy(ROOT / file, place)
    for folder in FOLDERS:
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / folder, place / folder, symlinks=True, ignore=ignored)
    return place


def contracts(tree: Path) -> "subprocess.CompletedProcess[str]":
    script = "import sys; sys.path.insert(0, '.'); from importlinter.cli import lint_imports_command; "
    command = [sys.executable, "-c", script + "lint_imports_command()", "--no-cache", "--no-logo"]
    return subprocess.run(command, cwd=tree, capture_output=True, text=True, check=False)
