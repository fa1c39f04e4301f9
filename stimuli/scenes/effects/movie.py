"""The field around the focus instant, frame by frame."""

from dataclasses import dataclass
from math import ceil
from typing import Any

from tactometry.arguments.require import expect

from ...composition.effect import Demand, Effect, Size, Stage, Surroundings, note
from ..stages.circuit import at_voltage

MAP = "tactometry.stimuli.scenes.stages.motion"
MOST_NUMBERS = 5e7
FRAMES_PER_PERIOD = 8
"""Frames per period of the band's top; at least four show the true direction of a wave."""


@dataclass(frozen=True)
class Movie(Effect):
    """A movie of equally spaced frames over `span_s`, with the focus instant in the middle.

    Parameters
    ----------
    n_frames : int, optional
        Number of frames. Default: 8 per period of the top of the band.
    span_s : float
        Duration shown, with the focus instant in the middle.
    """

    kind = "movie"
    positive = ("span_s",)
    cures = note("add the effect movie", "movie_m", "frames_s")

    n_frames: int | None = None
    span_s: float = 0.25e-3

    def __post_init__(self) -> None:
        super().__post_init__()
        expect(self.n_frames is None or self.n_frames >= 2, "Movie.n_frames", self.n_frames, "at least 2")

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        needs = ("motion", "frames_s", "x_m", "y_m")
        return (
            Stage("frames", (), "frames_s", f"{MAP}:frame_times", size=self._frames_size),
            Stage("movie", needs, "per_volt_movie", f"{MAP}:movie", size=self._movie_size),
            at_voltage("movie_at_voltage", "per_volt_movie", "movie_m", self._numbers_size),
        )

    def _frames_size(self, demand: Demand) -> Size:
        longest_s = 2 * min(demand.surface.reversal_s, demand.surface.after_s)
        expected = f"at most {longest_s}, twice the shorter of reversal_s and after_s; shorten it or raise them"
        expect(self.span_s <= longest_s, "movie", f"a span of {self.span_s} s", expected)
        return Size({"n_frames": self._n_frames(demand.surface), "span_s": self.span_s})

    def _n_frames(self, surface: Any) -> int:
        """Return the requested frames, or an odd number with one at the focus."""
        if self.n_frames is not None:
            return self.n_frames
        f_max_hz: float = surface.f_max_hz
        return 2 * ceil(FRAMES_PER_PERIOD * f_max_hz * self.span_s / 2) + 1

    def _numbers_size(self, demand: Demand) -> Size:
        return Size(n_operations=float(self._n_numbers(demand)))

    def _movie_size(self, demand: Demand) -> Size:
        return Size(error=demand.surface.grid_error(demand), n_operations=100.0 * self._n_numbers(demand))

    def _n_numbers(self, demand: Demand) -> int:
        n_x, n_y = demand.once(demand.surface.grid)
        n_frames = self._n_frames(demand.surface)
        n_numbers: int = n_frames * n_x * n_y
        expected = f"at most {MOST_NUMBERS:.2g} numbers; loosen the accuracy, lower n_frames or shorten span_s"
        expect(n_numbers <= MOST_NUMBERS, "movie", f"{n_frames} frames of {n_x} x {n_y} points", expected)
        return n_numbers
