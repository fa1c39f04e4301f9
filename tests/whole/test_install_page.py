"""The install page lists every package and extra with its purpose."""

from benchmark_modules import benchmark_module
from core_only import core_requirements, needed
from places import ROOT

SIZES = benchmark_module("install_size")
PAGE = (ROOT / "docs" / "how_to" / "install.md").read_text(encoding="utf-8")
NOT_FOR_USERS = {"dev", "docs"}


def rows(first: str) -> list[list[str]]:
    table = PAGE.partition(f"| {first} |")[2].partition("\n\n")[0]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]


def test_install_page_lists_each_core_package_once() -> None:
    listed = [name for name, _, others, _ in rows("package") for name in (name, *filter(None, others.split(", ")))]
    assert sorted(listed) == sorted(needed(core_requirements()))


def test_install_page_states_purpose_of_every_extra() -> None:
    extras = SIZES.PROJECT["optional-dependencies"].keys() - NOT_FOR_USERS
    assert {name.strip("`"): reason for name, _, reason in rows("extra")} == SIZES.EXTRAS
    assert SIZES.EXTRAS.keys() == extras


def test_size_tables_are_written_only_between_marks() -> None:
    text = "a\n<!-- sizes: begin -->\nold\n<!-- sizes: end -->\nb\n"
    assert SIZES.page_text(text, "new") == text.replace("old", "\nnew\n")


def test_package_size_includes_only_its_exclusive_dependencies() -> None:
    packages = {"one": (1.0, {"below"}), "two": (1.0, {"below", "deep"}), "below": (1.0, set()), "deep": (1.0, {"one"})}
    assert SIZES.brought(packages, ["one", "two"]) == {"one": ["below"], "two": ["deep"]}
