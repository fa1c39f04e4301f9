"""Drawing of pages: margins, contrast, and equality with PsychoPy."""

import numpy as np
import pytest
import screens
from screens import all_pages, other_pages

from tactometry.rigs.pages import layout
from tactometry.rigs.pages.page import Text
from tactometry.rigs.texts import languages


@pytest.mark.parametrize("language", languages())
def test_pages_fit_the_screen_with_high_contrast(screen, artefacts, language):
    pages = all_pages(language, screen.aspect) | (other_pages(screen.aspect) if language == "en" else {})
    for name, page in pages.items():
        image = screen.picture(page)
        image.save(artefacts / f"window_{language}_{name}.png")
        pixels = np.asarray(image.convert("L"), dtype=int)
        edge = np.concatenate([pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]])
        assert set(edge) == {pixels[0, 0]}, f"{name} touches the edge of the screen"
        assert pixels.max() - pixels[0, 0] > 100, f"{name} is hardly seen"


def pixels(screen, page):
    return np.asarray(screen.picture(page))


def plainly(canvas, item):
    if isinstance(item, Text):
        return canvas._text(item)
    look, size = canvas._look(item)
    shape = canvas._shape(*look)
    shape.pos, shape.size = (item.x, item.y), size
    return shape


@pytest.mark.parametrize("name", ["en_force_held", "form_nasa-tlx_en", "form_pleasantness-vas_en", "entry"])
def test_display_lists_match_psychopy_drawing(screen, name):
    """Pixels may differ by one, as display lists use single precision."""
    page = screens.every_page(screen.aspect)[name]
    recorded = pixels(screen, page).astype(int)
    for item in page.items:
        plainly(screen._canvas, item).draw()
    drawn = np.asarray(screen._window._getFrame(buffer="back")).astype(int)
    screen._window.clearBuffer()
    assert np.abs(recorded - drawn).max() <= 1


def test_moving_frames_do_not_call_psychopy(screen, monkeypatch):
    """PsychoPy's shape attributes are slow: forms took 110 ms per frame."""
    marker = layout.marker_page(1, playing=True, words="Press")
    forces = [layout.force_page(marker, force_n, 1.0, 0.2) for force_n in (0.9, 1.1)]
    frames = [layout.track_page(page, at, 0.5, 0.0) for page, at in zip(forces, (-0.1, 0.1), strict=True)]
    first = pixels(screen, frames[0])
    monkeypatch.delattr("psychopy.visual.basevisual.BaseVisualStim.pos")
    monkeypatch.delattr("psychopy.visual.shape.BaseShapeStim.draw")
    monkeypatch.delattr("psychopy.visual.shape.ShapeStim.draw")
    monkeypatch.delattr("psychopy.visual.TextStim.draw")
    assert not np.array_equal(pixels(screen, frames[1]), first)
    assert np.array_equal(pixels(screen, frames[0]), first)


def test_page_is_independent_of_earlier_pages(screen):
    shown = screens.every_page(screen.aspect)
    names = ["en_force_low", "form_nasa-tlx_en", "en_force_held", "form_sus_en", "entry", "form_attrakdiff_en"]
    first = {name: pixels(screen, shown[name]) for name in names}
    assert all(np.array_equal(pixels(screen, shown[name]), first[name]) for name in reversed(names))
    assert len({picture.tobytes() for picture in first.values()}) == len(names)
