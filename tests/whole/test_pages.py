"""Code blocks and commands of README and docs behave as shown."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from page_blocks import Block, blocks_of
from page_runner import COLUMNS, run_block, run_page
from places import DOCS, ROOT

from tactometry.cli import tactometry

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.glob("*.md")), *sorted(DOCS.glob("[a-z]*/**/*.md"))]
LONG = re.compile(r"^<!-- long: .+ -->$", re.MULTILINE)


def page_of(path: Path) -> object:
    """Return a test parameter of a page, marked slow if the page says so."""
    marks = pytest.mark.slow if LONG.search(path.read_text(encoding="utf-8")) else ()
    return pytest.param(path, marks=marks, id=path.relative_to(ROOT).with_suffix("").as_posix())


@pytest.fixture
def scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Yield a folder for a page, and forget the modules it writes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", COLUMNS)
    known = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - known:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(tmp_path)):
            del sys.modules[name]


@pytest.mark.parametrize("page", [page_of(path) for path in PAGES])
@pytest.mark.usefixtures("scratch")
def test_page_examples_are_current(page: Path) -> None:
    run_page(page)


NAMED = re.compile(r"`tactometry ([a-z-]+)((?: [^`]*)?)`")


def commands_named_in(path: Path) -> set[tuple[str, str]]:
    return set(NAMED.findall(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.relative_to(ROOT).with_suffix("").as_posix())
def test_commands_and_options_named_in_text_exist(page: Path) -> None:
    for name, rest in sorted(commands_named_in(page)):
        command = tactometry.get_command(click.Context(tactometry), name)
        assert command is not None
        for word in re.findall(r"^\w[\w-]*", rest.strip()):
            command = getattr(command, "commands", {}).get(word, command)
        known = {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
        assert set(re.findall(r"(?<=\s)--[a-z-]+", rest)) <= known | {"--help"}, f"{name}{rest}"


WRONG = {
    "other output": ("console", "$ tactometry studies\nno such study\n", "the page shows"),
    "an error that the page does not show": ("console", "$ tactometry analyse nowhere\n", "ended with 2"),
    "an error that does not come": ("console", "$ tactometry studies\ntactometry: no\n", "ended with 0"),
    "another program's error": ("console", "$ false\n", "ended with 1"),
    "another number": ("python", "print(1)  # 2\n", "the page says"),
    "a print without a comment": ("python", "print(1)\n", "the page says"),
    "an example": ("python", ">>> 1 + 1\n3\n", "Expected"),
    "TOML that nothing reads": ("toml", "a = 1\n", "what reads it"),
    "an unknown language": ("matlab", "a = 1;\n", "expected"),
    "no language": (None, "a = 1;\n", "expected"),
}


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.usefixtures("scratch")
def test_wrong_example_fails(wrong: str) -> None:
    language, text, complaint = WRONG[wrong]
    with pytest.raises(AssertionError, match=complaint):
        run_block(Block(Path("page.md"), 1, language, text), {})


@pytest.mark.usefixtures("scratch")
def test_study_fragment_with_unknown_key_fails() -> None:
    block = Block(Path("page.md"), 1, "toml", "[task]\nkind = 'yes_no'\nsort = 1\n", "study", "tutorial")
    with pytest.raises(Exception, match="task.sort"):
        run_block(block, {})


@pytest.mark.usefixtures("scratch")
def test_block_runs_when_its_program_is_installed() -> None:
    run_block(Block(Path("page.md"), 1, "console", "$ false\n", "with", "no-such-program"), {})
    with pytest.raises(AssertionError, match="ended with 1"):
        run_block(Block(Path("page.md"), 1, "console", "$ false\n", "with", "bash"), {})


NOT_RUN = [
    pytest.param(block, id=f"{path.relative_to(ROOT).with_suffix('').as_posix()}:{block.line}")
    for path in PAGES
    for block in blocks_of(path)
    if block.mark == "not run"
]


@pytest.mark.parametrize("block", NOT_RUN)
def test_reason_for_block_not_run_names_existing_tests(block: Block) -> None:
    """`pytest --collect-only -q -k not_run_names tests/whole/test_pages.py` lists all of them."""
    assert len(block.said.split()) > 2
    assert [path for path in re.findall(r"tests/[\w./]*\w", block.said) if not (ROOT / path).exists()] == []


@pytest.mark.parametrize("page", [page for page in PAGES if any(block.mark == "file" for block in blocks_of(page))])
def test_page_names_the_file_of_each_block(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert [block.said for block in blocks_of(page) if block.mark == "file" and f"`{block.said}`" not in text] == []


def test_skipped_block_states_the_reason(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("<!-- not run: it needs a force sensor -->\n```console\n$ false\n```\n", encoding="utf-8")
    [block] = blocks_of(page)
    assert (block.language, block.text, block.mark) == ("console", "$ false\n", "not run")
    assert block.said == "it needs a force sensor"
    run_block(block, {})
