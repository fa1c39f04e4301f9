"""Lag of friction relative to the electrostatic force."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import NotNegative, checked
from tactometry.contact import Contact
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ...composition.effect import Effect, Stage, Surroundings, is_changed
from ...composition.sampling import per_sample
from ..waveforms.pieces import Pieces
from .coulomb_friction import CoulombFriction

if TYPE_CHECKING:
    from ...perception.detection import Components
    from ..attraction.force import ForceForm


@dataclass(frozen=True)
class FrictionLag(Effect):
    """First-order low-pass filter between electrostatic force and friction, ``1/(1 + i f/f_c)``.

    ``f_c = max(floor, f_0 + slope v)``. The slope, 13.8 Hz per mm/s, is published (20 to 100 mm/s, 0.2 to
    0.6 N); the intercept has no source, the floor is a choice (`friction_lag` in `stimuli/sources.toml`).

    Parameters
    ----------
    slope_hz_per_m_per_s : float
        Rise of the cut-off frequency with the speed.
    intercept_hz : float
        Cut-off frequency at rest before the floor applies, `f_0`.
    floor_hz : float
        Lowest cut-off frequency.

    >>> float(FrictionLag().cutoff_hz(0.1) - FrictionLag().cutoff_hz(0.02)).__round__(6)
    1104.0
    """

    kind = "friction_lag"
    slot = "dynamics"
    positive = ("floor_hz",)
    not_negative = ("slope_hz_per_m_per_s", "intercept_hz")
    requires = ("friction", "sliding contact")
    reads, gives = ("components", "contact"), "components"

    slope_hz_per_m_per_s: float = 13_800.0
    intercept_hz: float = 0.0
    floor_hz: float = 100.0

    @checked
    def cutoff_hz(self, speed_m_per_s: NotNegative) -> float:
        """Return the cut-off frequency at a sliding speed (m/s, at least 0)."""
        return max(self.floor_hz, self.intercept_hz + self.slope_hz_per_m_per_s * speed_m_per_s)

    @checked
    def gain(self, frequency_hz: ArrayLike, speed_m_per_s: float) -> FloatArray:
        """Return the low-pass gain ``1/sqrt(1 + (f/f_c)^2)`` at force frequencies."""
        ratio = np.asarray(frequency_hz, dtype=np.float64) / self.cutoff_hz(speed_m_per_s)
        return 1 / np.hypot(1.0, ratio)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        needs = ("t_s", "voltage", "form", "friction_law", "contact")
        target, size = f"{__name__}:scene_friction_n", per_sample(280.0)
        return (Stage("friction_lag", needs, "friction_force_n", target, dict(vars(self)), size=size),)

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return a steady-state stage, or the slower exact one if needed."""
        if is_changed("friction_force_n", scene):
            return tuple(replace(stage, size=None) for stage in self.stages(scene))
        return (self.stage(),)

    def __call__(self, components: "Components", contact: Contact) -> "Components":
        return components.times(self.gain(components.frequencies_hz, contact.speed_m_per_s))


@checked
def lagged_friction_n(
    t_s: ArrayLike,
    pieces: Pieces,
    form: "ForceForm",
    *,
    lag: FrictionLag,
    friction: CoulombFriction,
    force_n: float,
    speed_m_per_s: float,
) -> FloatArray:
    """Return the exact friction (N) that lags behind ``mu (F_n + F_e)``.

    The shape is (n_times,). It is 0 for a finger at rest.

    The lag acts on the electrostatic part, from rest: ``f' = 2 pi f_c (mu F_e - f)``.

    Raises `InvalidParameter` if a value is outside of its domain, or the cut-off frequency is so high that rounding
    errors would exceed 1e-9 (`CYCLES_MAX`).

    >>> from tactometry.stimuli.electrovibration import Skin, Step
    >>> from tactometry.stimuli.electrovibration.attraction.force import force_form
    >>> pieces, form = Step(duration_s=0.1).pieces(40.0), force_form("parallel_plate", Skin(), 1e-4)
    >>> lag, friction = FrictionLag(slope_hz_per_m_per_s=0.0, floor_hz=100.0), CoulombFriction(0.5)
    >>> t_s = [0.0, 1 / (2 * np.pi * 100.0), 0.1]
    >>> friction_n = lagged_friction_n(t_s, pieces, form, lag=lag, friction=friction, force_n=1.0, speed_m_per_s=0.05)
    >>> friction_n.round(3).tolist()  # 0.5 (1 N + 17.3 N) in the end, 63 % of the way after one time constant
    [0.5, 5.957, 9.133]
    """
    from ..attraction.force import ForceForm  # imported only when a friction course is computed
    from .driven_motion import CYCLES_MAX, LinearSystem, check_times, first_order_response

    require.of_kind("lagged_friction_n", ForceForm, form=form)
    t = np.asarray(t_s, dtype=np.float64)
    mu = friction.coefficient_at(force_n)
    check_times(t, pieces)
    if speed_m_per_s == 0:
        return np.zeros_like(t)

    cutoff_hz = lag.cutoff_hz(speed_m_per_s)
    longest_s = float(np.diff(t, prepend=0.0).max())  # the plan starts at time 0, even if `t_s` does not
    if cutoff_hz == np.inf or cutoff_hz * longest_s > CYCLES_MAX:
        raise InvalidParameter(
            f"lagged_friction_n.lag: found a cut-off of {cutoff_hz:.3g} Hz with times up to {longest_s:.3g} s apart, "
            f"expected a product of at most {CYCLES_MAX:.0e}; such a short lag is negligible: use mu (F_n + F_e)"
        )

    rate_per_s = 2 * np.pi * cutoff_hz
    low_pass = LinearSystem(((-rate_per_s,),), (mu * rate_per_s,))
    return mu * force_n + first_order_response(pieces, form, low_pass, t)


def scene_friction_n(
    t_s: FloatArray, pieces: Pieces, form: "ForceForm", friction: CoulombFriction, contact: Contact, **lag: float
) -> FloatArray:
    """Return the lagged friction (N) of a scene, with shape (n_times,)."""
    settings = FrictionLag(**lag)
    force_n, speed_m_per_s = contact.force_n, contact.speed_m_per_s
    return lagged_friction_n(
        t_s, pieces, form, lag=settings, friction=friction, force_n=force_n, speed_m_per_s=speed_m_per_s
    )
