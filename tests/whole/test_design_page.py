"""docs/explanation/design.md matches the packages of the repository."""

import re
from pathlib import Path

import pytest
from places import DOCS, ROOT

from tactometry.cli import COMMANDS

PAGE = (DOCS / "explanation" / "design.md").read_text(encoding="utf-8")
PATHS = sorted(set(re.findall(r"`((?:tactometry|stimuli|protocols|analysis|experiments|tests)/[\w/.]*)`", PAGE)))
PICTURE = (DOCS / "explanation" / "design" / "rooms.svg").read_text(encoding="utf-8")
WINGS = ("experiments", "protocols", "stimuli", "analysis", "tactometry")
BOX = re.compile(r'<rect x="([\d.]+)" y="([\d.]+)" width="([\d.]+)" height="([\d.]+)" rx="8"')
TITLE = re.compile(r'<text x="([\d.]+)" y="([\d.]+)" font-size="16"[^>]*>([\w/]+)')
ROOM = re.compile(r'<text x="([\d.]+)" y="([\d.]+)" font-size="12(?:\.5)?" [^>]*text-anchor="middle"[^>]*>([\w-]+)')


def drawn(wing: str, picture: str = PICTURE) -> set[str]:
    """Return the packages in the box of a folder."""
    for left, top, width, height in (map(float, box) for box in BOX.findall(picture)):

        def inside(text: tuple[str, str, str], x=left, y=top, w=width, h=height) -> bool:
            return x < float(text[0]) < x + w and y < float(text[1]) < y + h

        if any(title[2].rstrip("/") == wing for title in filter(inside, TITLE.findall(picture))):
            return {room[2] for room in filter(inside, ROOM.findall(picture))}
    raise AssertionError(f"the picture has no box for {wing}/")


def folders(wing: Path) -> set[str]:
    rooms = {file.parent for file in wing.glob("*/__init__.py")}
    return {room.name for room in rooms if not room.is_symlink()} - {"cli"}


@pytest.mark.parametrize("path", PATHS)
def test_design_page_paths_exist(path: str) -> None:
    assert (ROOT / path).exists()


@pytest.mark.parametrize("wing", WINGS)
def test_design_picture_contains_each_package(wing: str) -> None:
    assert folders(ROOT / wing) - drawn(wing) == set()


@pytest.mark.parametrize("wing", WINGS)
def test_design_picture_names_existing_modules(wing: str) -> None:
    place = ROOT / wing
    assert drawn(wing)
    assert {room for room in drawn(wing) - folders(place) if not (place / f"{room}.py").is_file()} == set()


def test_the_picture_has_each_command() -> None:
    assert drawn("tactometry/cli") == set(COMMANDS)


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md"])
def test_contributing_links_the_design_page(page: str) -> None:
    assert "docs/explanation/design.md" in (ROOT / page).read_text(encoding="utf-8")
