"""Friction that lags behind the attraction, less so for a faster finger."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import checked

from ...arrays import FloatArray
from ...composition.effect import Effect, Stage, Surroundings
from ...composition.sampling import per_sample

if TYPE_CHECKING:
    from ...perception.detection import Components

LAGGING = "tactometry.stimuli.electrovibration.motion.friction:lagging"


@dataclass(frozen=True)
class FrictionLag(Effect):
    """First-order low-pass between electrostatic force and friction, ``1/(1 + i f/f_c)``.

    ``f_c = max(floor, f_0 + slope v)``. The slope, 13.8 Hz per mm/s, is published (20 to 100 mm/s, 0.2 to
    0.6 N); intercept and floor are unverified defaults.

    >>> float(FrictionLag().cutoff_hz(0.1) - FrictionLag().cutoff_hz(0.02)).__round__(6)
    1104.0
    """

    kind = "friction_lag"
    slot = "dynamics"
    positive = ("floor_hz",)
    not_negative = ("slope_hz_per_m_per_s", "intercept_hz")
    requires = ("friction", "sliding contact")

    slope_hz_per_m_per_s: float = 13_800.0
    intercept_hz: float = 0.0
    floor_hz: float = 100.0

    @checked
    def cutoff_hz(self, speed_m_per_s: float) -> float:
        """Corner frequency at a sliding speed (m/s, at least 0)."""
        require.not_negative("FrictionLag", speed_m_per_s=speed_m_per_s)
        return max(self.floor_hz, self.intercept_hz + self.slope_hz_per_m_per_s * speed_m_per_s)

    @checked
    def gain(self, frequency_hz: ArrayLike, speed_m_per_s: float) -> FloatArray:
        """``1/sqrt(1 + (f/f_c)^2)`` at force frequencies, of the shape of `frequency_hz`."""
        ratio = np.asarray(frequency_hz, dtype=np.float64) / self.cutoff_hz(speed_m_per_s)
        return 1 / np.hypot(1.0, ratio)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        needs, touch = ("t_s", "voltage", "form", "friction_law"), scene.contacts[0]
        settings = {**vars(self), "force_n": touch.force_n, "speed_m_per_s": touch.speed_m_per_s}
        return (Stage("friction_lag", needs, "friction_force_n", LAGGING, settings, size=per_sample(280.0)),)

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Of each component in its steady state, as the exact course costs a hundred times as much."""
        settings = {**vars(self), "speed_m_per_s": scene.contacts[0].speed_m_per_s}
        return (Stage("friction_lag", ("components",), "components", f"{__name__}:steady", settings),)


def steady(speed_m_per_s: float, **lag: float) -> "Callable[[Components], Components]":
    """Components behind a lag."""
    law = FrictionLag(**lag)
    return lambda parts: replace(parts, amplitudes=parts.amplitudes * law.gain(parts.frequencies_hz, speed_m_per_s))
