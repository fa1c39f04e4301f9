"""No screen: time passes in frames all the same."""

import time

from ..session.request import Facts
from .frame_timing import PERIOD_WITHOUT_BLANK_S
from .pages.page import Input, Page


class Blind:
    """A `tactometry.rigs.pages.page.Display` that shows nothing and on which nothing can be pressed."""

    aspect = 1.0
    period_s = PERIOD_WITHOUT_BLANK_S

    def prepare(self, page: Page) -> None:
        pass

    def present(self, page: Page) -> float:
        del page
        return time.perf_counter()

    def refresh(self, page: Page) -> float:
        time.sleep(self.period_s)
        return self.present(page)

    def events(self) -> tuple[Input, ...]:
        return ()

    def facts(self) -> Facts:
        return {}

    def frame_intervals_s(self) -> list[float]:
        return []

    def clock_offset_s(self) -> float:
        return 0.0

    def close(self) -> None:
        pass
