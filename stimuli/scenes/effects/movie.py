"""The field around the focus instant, frame by frame."""

from dataclasses import dataclass
from typing import Any

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ...composition.effect import Demand, Effect, Size, Stage, Surroundings, note
from ..stages.scaling import at_voltage

MAP = "tactometry.stimuli.scenes.stages.map"
MOST_NUMBERS = 5e7


@dataclass(frozen=True)
class Movie(Effect):
    """`n_frames` at equal steps over `span_s`, the focus in the middle.

    >>> Movie().n_frames
    61
    """

    kind = "movie"
    slot = "movie"
    positive = ("span_s",)
    cures = note("add the effect movie", "movie_m", "frames_s")

    n_frames: int = 61
    span_s: float = 0.5e-3

    def __post_init__(self) -> None:
        super().__post_init__()
        expect(self.n_frames >= 2, "Movie.n_frames", self.n_frames, "at least 2")

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        needs = ("motion", "frames_s", "x_m", "y_m")
        return (
            Stage("frames", (), "frames_s", f"{MAP}:frame_times", size=self._frames_size),
            Stage("movie", needs, "per_volt_movie", f"{MAP}:movie", size=self._movie_size),
            at_voltage("movie_at_voltage", "per_volt_movie", "movie_m", self._numbers_size),
        )

    def _frames_size(self, demand: Demand) -> Size:
        self._check_span(demand.surface)
        return Size({"n_frames": self.n_frames, "span_s": self.span_s})

    def _numbers_size(self, demand: Demand) -> Size:
        return Size(n_operations=float(self._n_numbers(demand)))

    def _movie_size(self, demand: Demand) -> Size:
        return Size(error=demand.surface.grid_error(demand), n_operations=100.0 * self._n_numbers(demand))

    def _n_numbers(self, demand: Demand) -> int:
        n_x, n_y = demand.once(demand.surface.grid)
        n_numbers: int = self.n_frames * n_x * n_y
        if n_numbers > MOST_NUMBERS:
            raise InvalidParameter(
                f"movie: found {self.n_frames} frames of {n_x} x {n_y} points, expected at most {MOST_NUMBERS:.2g} "
                "numbers; loosen the accuracy or lower n_frames"
            )
        return n_numbers

    def _check_span(self, surface: Any) -> None:
        longest_s = 2 * min(surface.reversal_s, surface.after_s)
        if self.span_s > longest_s:
            raise InvalidParameter(
                f"movie: found a span of {self.span_s} s, expected at most {longest_s}, twice the shorter of "
                "reversal_s and after_s; shorten it or raise those"
            )
