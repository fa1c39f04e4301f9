"""Images on text pages, and errors before a session begins."""

from dataclasses import replace

import pytest
from command_line import call
from PIL import Image as Pillow
from study_texts import TUTORIAL

from tactometry.errors import TactometryError
from tactometry.provenance import sha256
from tactometry.rigs.bench import Bench
from tactometry.rigs.device_rig import Equipment
from tactometry.rigs.pages.page import Picture
from tactometry.rigs.texts import ImageTable, image_of, texts_in
from tactometry.session.request import Show

RED, BLUE = (255, 0, 0), (0, 0, 255)


@pytest.fixture
def file(tmp_path):
    image = Pillow.new("RGB", (300, 150), RED)
    image.paste(BLUE, (150, 0, 300, 150))
    image.save(tmp_path / "setup.png")
    return tmp_path / "setup.png"


def stated(file):
    return ImageTable(str(file), sha256(file.read_bytes()))


def test_image_is_drawn_upright_on_its_page_only(watched, output, file, artefacts):
    texts = replace(texts_in("en", {}), images={"welcome": image_of(stated(file), "images.welcome")})
    rig = Bench(watched, Equipment(output, {}), texts)
    page = rig._message(Show("welcome", {}), "hint_continue")
    [drawn] = [item for item in page.items if isinstance(item, Picture)]
    assert drawn.width / drawn.height == pytest.approx(2.0)
    for _ in range(2):  # redrawing gives the same picture
        shown = watched.picture(page).convert("RGB")
    shown.save(artefacts / "image.png")
    width, height = shown.size
    y = round((0.5 - drawn.y) * height)
    left, right = (shown.getpixel((round(width / 2 + side * drawn.width * height / 4), y)) for side in (-1, 1))
    assert (left, right) == (RED, BLUE)
    assert not [item for item in rig._message(Show("rest", {}), "").items if isinstance(item, Picture)]
    rig.close()


def test_invalid_images_are_refused(file):
    (file.parent / "words.png").write_text("no image")
    for table, message in (
        (ImageTable("absent.png"), "absent.png: cannot be read"),
        (ImageTable(str(file)), "images.end.sha256: found no such key, expected that of"),
        (replace(stated(file), sha256="0"), "images.end.sha256: found '0', expected that of"),
        (stated(file.parent / "words.png"), "images.end.path: found .*words.png', which is not an image"),
    ):
        with pytest.raises(TactometryError, match=message):
            image_of(table, "images.end")


@pytest.mark.parametrize(
    ("words", "table", "message"),
    [
        (("--rig", "simulated"), '[images.welcom]\npath = "setup.png"\n', "images: found 'welcom', expected one of "),
        ((), '[images.welcome]\npath = "setup.png"\n', "setup.png: cannot be read"),
        (("--dry-run",), '[images.welcome]\npath = "setup.png"\n', "setup.png: cannot"),
    ],
    ids=["page", "file", "dry run"],
)
def test_session_does_not_start_without_its_image(tmp_path, capsys, words, table, message):
    (tmp_path / "s.toml").write_text(f"{TUTORIAL}{table}", "utf-8")
    run = ("run", tmp_path / "s.toml", "--participant", "P01", *words, "--out", tmp_path / "d")
    status, said, _ = call(capsys, *run)
    assert status == 2
    assert message in said
    assert not (tmp_path / "d").exists()
