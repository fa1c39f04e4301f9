"""The field around the focus instant, frame by frame."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from tactometry import require
from tactometry.errors import InvalidParameter
from tactometry.stimuli.scenes.effect import Budget, Surroundings
from tactometry.stimuli.scenes.stage import Stage

if TYPE_CHECKING:
    from tactometry.stimuli.scenes.time_reversal.map import FloatArray
    from tactometry.stimuli.scenes.time_reversal.motion import Motion

MOST_NUMBERS = 5e7


@dataclass(frozen=True)
class Movie:
    """`n_frames` at equal steps over `span_s`, the focus in the middle.

    >>> Movie().n_frames
    61
    """

    kind: ClassVar[str] = "movie"
    slot: ClassVar[str] = "movie"
    requires: ClassVar[tuple[str, ...]] = ()
    excludes: ClassVar[Mapping[str, str]] = {}

    n_frames: int = 61
    span_s: float = 0.5e-3

    def __post_init__(self) -> None:
        require.positive("Movie", span_s=self.span_s)
        if self.n_frames < 2:
            raise InvalidParameter(f"Movie.n_frames: found {self.n_frames}, expected at least 2")

    def stages(self, scene: Surroundings, budget: Budget) -> tuple[Stage, ...]:
        surface: Any = scene.surface
        self._check_span(surface)
        n_x, n_y = surface.grid(scene, budget.error)
        n_numbers = float(self.n_frames * n_x * n_y)
        if n_numbers > MOST_NUMBERS and "movie_m" in scene.outputs:
            raise InvalidParameter(
                f"movie: found {self.n_frames} frames of {n_x} x {n_y} points, expected at most {MOST_NUMBERS:.2g} "
                "numbers; loosen the accuracy or lower n_frames"
            )
        times = {"n_frames": self.n_frames, "span_s": self.span_s}
        return (
            Stage(
                "frames",
                (),
                "frames_s",
                "tactometry.stimuli.scenes.time_reversal.map:frame_times",
                times,
                effect=self.kind,
            ),
            Stage(
                "movie",
                ("motion", "frames_s", "x_m", "y_m"),
                "per_volt_movie",
                f"{__name__}:drawn",
                n_operations=100 * n_numbers,
                effect=self.kind,
            ),
            Stage(
                "movie_at_voltage",
                ("per_volt_movie", "voltage_v"),
                "movie_m",
                "tactometry.stimuli.scenes.surfaces.time_reversal:multiplied",
                n_operations=n_numbers,
                effect=self.kind,
            ),
        )

    def _check_span(self, surface: Any) -> None:
        longest_s = 2 * min(surface.reversal_s, surface.after_s)
        if self.span_s > longest_s:
            raise InvalidParameter(
                f"movie: found a span of {self.span_s} s, expected at most {longest_s}, twice the shorter of "
                "reversal_s and after_s; shorten it or raise those"
            )


def drawn() -> "Callable[[Motion, FloatArray, FloatArray, FloatArray], FloatArray]":
    """The frames (m/V)."""
    from tactometry.stimuli.scenes.time_reversal.map import movie

    return movie()
