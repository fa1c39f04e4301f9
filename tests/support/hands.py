"""Hands that press keys and touch a display by real X events."""

import time

SCREEN_PX = (1280, 800)


class Hands:
    def __init__(self, name):
        from Xlib import XK, X, display
        from Xlib.ext import xtest

        self._X, self._XK, self._xtest = X, XK, xtest
        self._display, self._curtain = display.Display(name), None

    def _send(self, kind, detail=0, x=0, y=0):
        self._xtest.fake_input(self._display, kind, detail, x=x, y=y)
        self._display.sync()

    def tap(self, key, hold_s=0.03):
        """Tap a key; return its times of press and release."""
        code = self._display.keysym_to_keycode(self._XK.string_to_keysym(key))
        down_s = time.perf_counter()
        self._send(self._X.KeyPress, code)
        time.sleep(hold_s)
        self._send(self._X.KeyRelease, code)
        return down_s, time.perf_counter()

    def touch(self, x, y):
        self.drag((x, y))

    def drag(self, *places):
        for n, place in enumerate(places):
            self._move(*place)
            if n == 0:
                self._send(self._X.ButtonPress, 1)
        self._send(self._X.ButtonRelease, 1)

    def _move(self, x, y):
        width, height = SCREEN_PX
        self.point(round(width / 2 + x * height), round(height / 2 - y * height))

    def click(self, x_px, y_px):
        self._send(self._X.MotionNotify, x=x_px, y=y_px)
        self._send(self._X.ButtonPress, 1)
        self._send(self._X.ButtonRelease, 1)

    def point(self, x_px, y_px):
        """Move the pointer; return its position from the server, px."""
        self._send(self._X.MotionNotify, x=x_px, y=y_px)
        place = self._display.screen().root.query_pointer()
        return place.root_x, place.root_y

    def sees(self):
        """Return the pixels of the screen, height x width x RGB."""
        import numpy as np

        width, height = SCREEN_PX
        image = self._display.screen().root.get_image(0, 0, width, height, self._X.ZPixmap, 0xFFFFFFFF)
        return np.frombuffer(image.data, np.uint8).reshape(height, width, 4)[..., 2::-1]

    def sees_at(self, x_px, y_px):
        """Return one pixel as RGB, much faster than the whole screen."""
        image = self._display.screen().root.get_image(x_px, y_px, 1, 1, self._X.ZPixmap, 0xFFFFFFFF)
        return tuple(image.data[2::-1])

    def cover(self):
        """Put black in front of all windows, until the next one opens."""
        if self._curtain is None:
            root, like_root = self._display.screen().root, self._X.CopyFromParent
            self._curtain = root.create_window(0, 0, *SCREEN_PX, 0, like_root, background_pixel=0)
            self._curtain.map()
        self._curtain.raise_window()
        self._display.sync()

    def uncover(self):
        if self._curtain is not None:
            self._curtain.destroy()
            self._display.sync()
            self._curtain = None

    def close(self):
        self._display.close()
