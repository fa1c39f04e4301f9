"""The page of what is installed names every package and extra, each with its reason."""

from benchmark_modules import benchmark_module
from core_only import core_requirements, needed
from places import ROOT

SIZES = benchmark_module("install_size")
PAGE = (ROOT / "docs" / "how_to" / "install.md").read_text(encoding="utf-8")
NOT_FOR_USERS = {"dev", "docs"}


def rows(first: str) -> list[list[str]]:
    """Those of the table whose first column is of this name."""
    table = PAGE.partition(f"| {first} |")[2].partition("\n\n")[0]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]


def test_install_page_lists_each_core_package_once() -> None:
    told = [name for name, _, others, _ in rows("package") for name in (name, *filter(None, others.split(", ")))]
    assert sorted(told) == sorted(needed(core_requirements()))


def test_every_extra_stands_on_the_page_with_what_it_is_for() -> None:
    extras = SIZES.PROJECT["optional-dependencies"].keys() - NOT_FOR_USERS
    assert {name.strip("`"): reason for name, _, reason in rows("extra")} == SIZES.EXTRAS
    assert SIZES.EXTRAS.keys() == extras


def test_the_tables_are_written_between_their_marks_and_nowhere_else() -> None:
    text = "a\n<!-- sizes: begin -->\nold\n<!-- sizes: end -->\nb\n"
    assert SIZES.page_text(text, "new") == text.replace("old", "\nnew\n")


def test_a_package_counts_with_what_it_alone_brings() -> None:
    packages = {"one": (1.0, {"below"}), "two": (1.0, {"below", "deep"}), "below": (1.0, set()), "deep": (1.0, {"one"})}
    assert SIZES.brought(packages, ["one", "two"]) == {"one": ["below"], "two": ["deep"]}
