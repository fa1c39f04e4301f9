"""docs/design.md shows the house as it is: every path stands, every room in the picture is one."""

import re

import pytest
from places import DOCS, ROOT

PAGE = (DOCS / "design.md").read_text(encoding="utf-8")
PATHS = sorted(set(re.findall(r"`((?:tactometry|stimuli|protocols|analysis|experiments|tests)/[\w/.]*)`", PAGE)))
PICTURE = (DOCS / "design" / "rooms.svg").read_text(encoding="utf-8")
WINGS = ("tactometry/cli", "experiments", "protocols", "stimuli", "analysis", "tactometry")


@pytest.mark.parametrize("path", PATHS)
def test_a_path_on_the_page_stands(path) -> None:
    assert (ROOT / path).exists()


def test_a_room_in_the_picture_is_one() -> None:
    drawn = re.findall(r'font-size="12(?:\.5)?" font-weight="normal" text-anchor="middle"[^>]*>([\w/]+)', PICTURE)
    assert len(drawn) > 50
    for name in drawn:
        stands = [ROOT / wing / name for wing in WINGS]
        assert any(place.is_dir() or place.with_suffix(".py").exists() for place in stands), name


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md"])
def test_who_begins_is_led_to_the_page(page) -> None:
    assert "docs/design.md" in (ROOT / page).read_text(encoding="utf-8")
