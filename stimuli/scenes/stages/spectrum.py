"""Components of a record: peaks of its spectrum through a window, refined until they are read off exactly enough.

They are read as everywhere (`tactometry.stimuli.perception.detection.components`), padded as far as asked. What is then
lost is how far the transform of the window is from a parabola in logarithms over three lines: known in closed
form. An error of frequency counts by the steepest slope of sensitivity.
"""

from math import exp, log, pi, sin
from typing import TYPE_CHECKING

from ...composition.effect import Demand, Size
from ...composition.sampling import content_of, samples
from ...perception.detection import WINDOW, components

if TYPE_CHECKING:
    from ...arrays import FloatArray
    from ...perception.detection import Components

PADDINGS = (1, 2, 4, 8, 16, 32, 64)
MOST_LINES = 3e7
N_OFFSETS = 21


def peak_error(padding: int, duration_s: float, steepest_db_per_hz: float) -> float:
    """Largest relative error of a component above threshold by lines ``1/padding`` apart.

    >>> peak_error(1, 1.0, steepest_db_per_hz=0.69) < 0.03, peak_error(8, 1.0, 0.69) < 1e-4
    (True, True)
    """
    offsets = [k / (2 * (N_OFFSETS - 1)) for k in range(N_OFFSETS)]
    readings = [_read_off(offset, padding) for offset in offsets]
    per_line = steepest_db_per_hz * log(10) / 20 / duration_s
    return max(abs(height - 1) + per_line * abs(away) / padding for height, away in readings)


def padding_for(error: float, duration_s: float, steepest_db_per_hz: float, n: int = 1) -> int:
    """The smallest padding of `n` samples whose error is at most `error`, or the largest that fits.

    >>> padding_for(1e-4, 1.0, steepest_db_per_hz=0.69) <= 8, padding_for(1e-9, 1.0, 0.69)
    (True, 64)
    """
    fits = [padding for padding in PADDINGS if padding * n <= MOST_LINES] or PADDINGS[:1]
    return next((padding for padding in fits if peak_error(padding, duration_s, steepest_db_per_hz) <= error), fits[-1])


def size(demand: Demand) -> Size:
    """How finely the components of a record are read off."""
    duration_s: float = demand.surface.duration_s
    n, steepest_db_per_hz = demand.once(samples), content_of(demand).steepest_db_per_hz
    padding = padding_for(demand.error, duration_s, steepest_db_per_hz, n)
    error = peak_error(padding, duration_s, steepest_db_per_hz)
    return Size({"padding": padding}, error, n_operations=300.0 * padding * n)


def components_of(t_s: "FloatArray", record: "FloatArray", padding: int) -> "Components":
    """The components of a record (n_samples,) at equal steps, its mean left out."""
    # a period of the transform ends before the sample that would begin the next
    return components(record[:-1], (record.size - 1) / float(t_s[-1]), padding)


def _read_off(offset: float, padding: int) -> tuple[float, float]:
    """Height, and place in lines off the truth, that a parabola reads off a component `offset` lines off a line."""
    before, at, after = (log(_transform((offset + k) / padding) / WINDOW[0]) for k in (1, 0, -1))
    away = (before - after) / (2 * (before - 2 * at + after))
    return exp(at - (before - after) * away / 4), away - offset


def _transform(lines: float) -> float:
    """Fourier transform of the window, `lines` off its middle, over its length; for a long record."""

    def sinc(x: float) -> float:
        return 1.0 if x == 0 else sin(pi * x) / (pi * x)

    sides = [WINDOW[k] / 2 * (sinc(lines - k) + sinc(lines + k)) for k in range(1, len(WINDOW))]
    return WINDOW[0] * sinc(lines) + sum(sides)
