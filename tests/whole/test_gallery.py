"""The gallery contains the pictures that its pages draw."""

import pytest
from gallery import GALLERY, PAGES, PICTURES, first_page, pictures_of
from page_blocks import blocks_of
from PIL import Image
from small_pictures import MOST_BYTES as MOST_BYTES_EACH

MOST_BYTES = 3_000_000
EVERY = [picture for page in PAGES for picture in pictures_of(page)]


def test_gallery_index_shows_every_section() -> None:
    assert (GALLERY / "index.md").read_text(encoding="utf-8") == first_page()
    assert sum(page.read_text(encoding="utf-8").count("\n## ") for page in PAGES) == len(EVERY)


def test_gallery_pages_match_the_folder() -> None:
    assert {*PAGES, GALLERY / "index.md"} == set(GALLERY.glob("*.md"))


def test_gallery_has_only_its_pictures_in_few_bytes() -> None:
    kept = list(PICTURES.iterdir())
    assert sorted(path.stem for path in kept) == sorted(picture.name for picture in EVERY)
    assert sum(path.stat().st_size for path in kept) < MOST_BYTES


@pytest.mark.parametrize("path", sorted(PICTURES.iterdir()), ids=lambda path: path.stem)
def test_picture_is_small_and_opaque(path) -> None:
    assert path.stat().st_size <= MOST_BYTES_EACH
    with Image.open(path) as picture:
        assert picture.format == "PNG"
        assert picture.mode == "P"
        assert "transparency" not in picture.info


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_page_holds_code_that_runs(page) -> None:
    run = [block for block in blocks_of(page) if block.language in {"console", "python"} and block.mark != "not run"]
    assert len(run) >= 2
