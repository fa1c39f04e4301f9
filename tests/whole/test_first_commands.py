"""The commands of the README, pasted one after another into one shell."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from page_blocks import blocks_of
from page_runner import commands_of
from places import ROOT

STUB = '#!/bin/sh\necho tactometry "$@"\n'


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A folder with the Makefile and an environment whose tactometry prints its arguments."""
    programs = tmp_path / ".venv" / "bin"
    programs.mkdir(parents=True)
    (tmp_path / "requirements").mkdir()
    shutil.copy(ROOT / "Makefile", tmp_path)
    # The environment is newer than what it is made from, so make does not install.
    for number, name in enumerate(
        ("pyproject.toml", "setup.py", "requirements/core.txt", ".venv/.python", ".venv/.core")
    ):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (number, number))
    (programs / "tactometry").write_text(STUB)
    (programs / "tactometry").chmod(0o755)
    (programs / "activate").write_text(f'PATH="{programs}:$PATH"\n')
    return tmp_path


def shell(folder: Path, lines: list[str]) -> str:
    done = subprocess.run(
        ["bash", "-euc", "\n".join(lines)],
        cwd=folder,
        env={"PATH": "/usr/bin:/bin"},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout


@pytest.mark.skipif(shutil.which("make") is None, reason="needs make")
def test_make_demo_ends_with_the_activation_line(clone: Path) -> None:
    last = shell(clone, ["make demo"]).splitlines()[-1]
    assert last.startswith("next: . .venv/bin/activate ")


@pytest.mark.skipif(shutil.which("make") is None, reason="needs make")
def test_readme_commands_run_in_one_shell(clone: Path) -> None:
    blocks = [block for block in blocks_of(ROOT / "README.md") if block.language == "console"]
    lines = [command.line for block in blocks for command in commands_of(block.text)]
    said = shell(clone, lines).splitlines()
    assert "make demo" in lines[0]
    assert [line.split()[1] for line in said if line.startswith("tactometry")] == ["demo", "new", "run", "analyse"]
