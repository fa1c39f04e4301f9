"""The calibration bar of a display, as the X server shows it."""

import numpy as np
import pytest
from emulated import wait_for
from hands import SCREEN_PX

from tactometry.cli import main
from tactometry.errors import Stopped
from tactometry.experiments.bench.calibration import show_bar


class Ruler:
    """A simulated user who measures the bar and types its length."""

    def __init__(self, hands):
        self._hands, self._root = hands, hands._display.screen().root
        self._n_windows = self._n_shown()
        self.length_px, self.n_windows_when_asked = 0, None

    def _n_shown(self):
        from Xlib import X

        return sum(each.get_attributes().map_state == X.IsViewable for each in self._root.query_tree().children)

    def _bar_px(self):
        from Xlib import X

        shown = self._root.get_image(0, 0, *SCREEN_PX, X.ZPixmap, 0xFFFFFFFF)
        pixels = np.frombuffer(shown.data, np.uint8).reshape(SCREEN_PX[1], SCREEN_PX[0], 4)[..., :3].min(axis=2)
        column = pixels[:, SCREEN_PX[0] // 2 - SCREEN_PX[1] // 2]
        return int(np.count_nonzero(column > 200))

    def measure(self):
        wait_for(lambda: self._n_shown() > self._n_windows and self._bar_px() > 0)
        self.length_px = self._bar_px()
        self._hands.tap("space")

    def readline(self, size=-1):
        del size
        self.n_windows_when_asked = self._n_shown() - self._n_windows
        return f"{self.length_px * 2.5e-4}\n"


def test_calibration_bar_is_half_the_screen_height(display, screen, monkeypatch, capsys, in_background):
    """The window of the command closes before the terminal asks for a length.

    It shares its keyboard with the window of the other tests, so the keyboard is restarted afterwards.
    """
    ruler = Ruler(display)
    monkeypatch.setattr("sys.stdin", ruler)
    in_background(ruler.measure)
    with pytest.raises(SystemExit) as ended:
        main(["calibrate", "display"])
    screen._keyboard.start()
    assert ended.value.code == 0
    assert ruler.length_px == pytest.approx(SCREEN_PX[1] / 2, abs=2)
    assert ruler.n_windows_when_asked == 0
    assert capsys.readouterr().out.startswith(f"[screen]\nheight_m = {2 * ruler.length_px * 2.5e-4!r}")


def test_escape_leaves_the_bar_without_measurement(watched, participant):
    participant.answers("Escape")
    with pytest.raises(Stopped, match="Escape was pressed; nothing was measured"):
        show_bar(watched)
