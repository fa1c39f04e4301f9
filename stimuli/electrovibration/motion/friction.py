"""Friction of a sliding finger under an added electrostatic load."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import checked
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ..attraction.force import ForceForm
from ..waveforms.pieces import Pieces
from .driven_motion import CYCLES_MAX, check_times, driven
from .lift import LinearSystem


@dataclass(frozen=True)
class CoulombFriction:
    """``F_f = mu (F_n + F_e)`` with ``mu = mu_1 (F_n/1 N)^exponent``.

    A coefficient of 0.5 at 1 N is an unverified default; with an exponent below 0 it falls with load. The load F_n is
    that of the finger: the voltage does not change the coefficient.

    >>> float(CoulombFriction(0.5).modulation_n(0.01, force_n=1.0))
    0.005
    """

    coefficient: float = 0.5
    load_exponent: float = 0.0

    def __post_init__(self) -> None:
        require.not_negative("CoulombFriction", coefficient=self.coefficient)
        require.finite("CoulombFriction", load_exponent=self.load_exponent)

    def coefficient_at(self, force_n: float) -> float:
        """The coefficient under a normal force (N).

        Without one it is the constant coefficient (the voltage alone causes friction, ``mu F_e``), 0 for an exponent
        above 0, and without a limit for an exponent below 0, which is refused.

        >>> CoulombFriction(0.5).coefficient_at(0.0), CoulombFriction(0.5, load_exponent=0.1).coefficient_at(0.0)
        (0.5, 0.0)
        """
        require.not_negative("CoulombFriction", force_n=force_n)
        try:
            return float(self.coefficient * float(force_n) ** self.load_exponent)
        except (OverflowError, ZeroDivisionError):
            raise InvalidParameter(
                f"CoulombFriction.load_exponent: found {self.load_exponent} for a normal force of {force_n} N, "
                "expected a coefficient within the range of a double"
            ) from None

    @checked
    def modulation_n(self, electrostatic_n: ArrayLike, force_n: float) -> FloatArray:
        """Change of the friction force, ``mu F_e``, of the shape of `electrostatic_n`."""
        with np.errstate(over="ignore"):
            change_n = self.coefficient_at(force_n) * np.asarray(electrostatic_n, dtype=np.float64)
        return require.in_range("CoulombFriction.modulation_n", change_n)


@dataclass(frozen=True)
class FrictionLag:
    """First-order low-pass between electrostatic force and friction, ``1/(1 + i f/f_c)``.

    ``f_c = max(floor, f_0 + slope v)``. The slope, 13.8 Hz per mm/s, is published (20 to 100 mm/s, 0.2 to
    0.6 N); intercept and floor are unverified defaults.

    >>> float(FrictionLag().cutoff_hz(0.1) - FrictionLag().cutoff_hz(0.02)).__round__(6)
    1104.0
    """

    slope_hz_per_m_per_s: float = 13_800.0
    intercept_hz: float = 0.0
    floor_hz: float = 100.0

    def __post_init__(self) -> None:
        require.not_negative(
            "FrictionLag", slope_hz_per_m_per_s=self.slope_hz_per_m_per_s, intercept_hz=self.intercept_hz
        )
        require.positive("FrictionLag", floor_hz=self.floor_hz)

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


@checked
def lagged_friction_n(
    t_s: ArrayLike,
    pieces: Pieces,
    form: ForceForm,
    *,
    lag: FrictionLag,
    friction: CoulombFriction,
    force_n: float,
    speed_m_per_s: float,
) -> FloatArray:
    """(n_times,) friction force (N) that lags behind ``mu (F_n + F_e)``, exactly; 0 for a finger at rest.

    The lag acts on the electrostatic part, from rest: ``f' = 2 pi f_c (mu F_e - f)``.

    Raises
    ------
    InvalidParameter
        If a value is outside of its domain, or the corner is so high that rounding would pass 1e-9 (`CYCLES_MAX`).

    >>> from tactometry.stimuli.electrovibration import Skin, Step, force_form
    >>> pieces, form = Step(duration_s=0.1).pieces(40.0), force_form("parallel_plate", Skin(), 1e-4)
    >>> lag, friction = FrictionLag(slope_hz_per_m_per_s=0.0, floor_hz=100.0), CoulombFriction(0.5)
    >>> t_s = [0.0, 1 / (2 * np.pi * 100.0), 0.1]
    >>> friction_n = lagged_friction_n(t_s, pieces, form, lag=lag, friction=friction, force_n=1.0, speed_m_per_s=0.05)
    >>> friction_n.round(3).tolist()  # 0.5 (1 N + 17.3 N) in the end, 63 % of the way after one time constant
    [0.5, 5.957, 9.133]
    """
    t = np.asarray(t_s, dtype=np.float64)
    mu = friction.coefficient_at(force_n)
    check_times(t, pieces)
    if speed_m_per_s == 0:
        return np.zeros_like(t)
    rate_per_s = 2 * np.pi * _resolved_hz(lag.cutoff_hz(speed_m_per_s), t)
    low_pass = LinearSystem(((-rate_per_s,),), (mu * rate_per_s,))
    (lagging_n,) = driven(pieces, form, low_pass, t)
    return np.asarray(mu * force_n + lagging_n)


def _resolved_hz(cutoff_hz: float, t_s: FloatArray) -> float:
    """The corner of a lag that the solution over these times resolves."""
    longest_s = float(np.diff(t_s, prepend=0.0).max())  # the motion begins at 0, asked for or not
    if cutoff_hz == np.inf or cutoff_hz * longest_s > CYCLES_MAX:
        raise InvalidParameter(
            f"lagged_friction_n.lag: found a corner of {cutoff_hz:.3g} Hz with times up to {longest_s:.3g} s apart, "
            f"expected a product of at most {CYCLES_MAX:.0e}; a lag that short is none: take mu (F_n + F_e)"
        )
    return cutoff_hz
