"""Friction lags behind the attraction by a first-order low-pass that is faster for a faster finger."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tactometry.arguments import require

from ...composition.effect import Effect, Stage, Surroundings
from ...composition.sampling import per_sample

if TYPE_CHECKING:
    from ...arrays import FloatArray
    from ...electrovibration.attraction.force import ForceForm
    from ...electrovibration.motion.friction import CoulombFriction
    from ...electrovibration.waveforms.pieces import Pieces


@dataclass(frozen=True)
class FrictionLag(Effect):
    """``f_c = max(floor, f_0 + slope v)``: the slope is published, intercept and floor are unverified defaults.

    >>> FrictionLag().slope_hz_per_m_per_s
    13800.0
    """

    kind = "friction_lag"
    slot = "dynamics"
    requires = ("friction", "sliding contact")

    slope_hz_per_m_per_s: float = 13_800.0
    intercept_hz: float = 0.0
    floor_hz: float = 100.0

    def __post_init__(self) -> None:
        require.positive("FrictionLag", floor_hz=self.floor_hz)
        require.not_negative(
            "FrictionLag", slope_hz_per_m_per_s=self.slope_hz_per_m_per_s, intercept_hz=self.intercept_hz
        )

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        touch = scene.contacts[0]
        settings = {
            "slope_hz_per_m_per_s": self.slope_hz_per_m_per_s,
            "intercept_hz": self.intercept_hz,
            "floor_hz": self.floor_hz,
            "force_n": touch.force_n,
            "speed_m_per_s": touch.speed_m_per_s,
        }
        return (
            Stage(
                "friction_lag",
                ("t_s", "voltage", "form", "friction_law"),
                "friction_force_n",
                f"{__name__}:lagging",
                settings,
                size=per_sample(280.0),
            ),
        )


def lagging(
    slope_hz_per_m_per_s: float, intercept_hz: float, floor_hz: float, force_n: float, speed_m_per_s: float
) -> "Callable[[FloatArray, Pieces, ForceForm, CoulombFriction], FloatArray]":
    """The lagging friction, exactly."""
    from ...electrovibration.motion import friction as laws

    lag = laws.FrictionLag(slope_hz_per_m_per_s, intercept_hz, floor_hz)
    return lambda t_s, voltage, form, friction: laws.lagged_friction_n(
        t_s, voltage, form, lag=lag, friction=friction, force_n=force_n, speed_m_per_s=speed_m_per_s
    )
