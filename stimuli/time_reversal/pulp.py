"""Normal impedance of the finger pulp: a rigid disc on a viscoelastic half-space.

The plate moves the contact, a disc of radius a, by u. The surface around it is free, and there is no friction. A
pressure of wavenumber x / a moves the surface by the compliance of a half-space (Lamb 1904; Miller and Pursey 1954)

    g(x) = a alpha / (G (q^2 + 4 x^2 (1 - e) beta / (alpha + beta))),
    alpha^2 = x^2 + p^2, beta^2 = x^2 + q^2, p = s a / c_p, q = s a / c_s, e = (p / q)^2.

The pressure is a sum of P_2n(v) / v, v^2 = 1 - r^2 / a^2, whose transforms are the spherical Bessel functions j_2n(x):
the first is the static solution. The symmetric equations of Galerkin's method give the force. Limits:
the stiffness 4 G a / (1 - nu) at low frequency (8 G a without compression, as the viscous 8 eta a s), the mass
4/3 rho a^3 of a disc in a liquid where shear is weak and sound longer than the disc, and the resistance rho c pi a^2 of
plane waves of compression at high frequency.
"""

from dataclasses import dataclass, field
from functools import lru_cache
from math import cos, pi, sin
from typing import Annotated, Any, Final

import numpy as np
from annotated_types import Ge, Interval
from numpy.polynomial.chebyshev import chebinterpolate, chebval
from numpy.polynomial.legendre import leggauss

from tactometry.arguments.checked import NotNegative, Positive, checked
from tactometry.arguments.require import expect

from ..arrays import ComplexArray, FloatArray
from ..defaults import SHEAR_VISCOSITY_PA_S
from .plate.modes import Modes, values
from .plate.plate import Plate
from .responses.responses import Point
from .screen.screen import Screen

N_PRESSURES: Final = 6
NODES: Final = 8
PANEL: Final = 3.0
"""Nodes of Gauss's rule for each panel of the path, and the longest panel."""
RISE: Final = 0.5
"""Height of the integration path above the real axis; the poles of the waves are on and below that axis."""
SHORTEST_PATH, SHEAR_WAVES = 64.0, 3.0
"""Smallest end of the path, and its end in wavenumbers of shear waves; beyond it the static compliance holds."""
MOST_SHEAR: Final = 4096.0
"""Radii of the disc in wavenumbers of shear waves that the pressures resolve."""
DEGREE, SLOW_RAD_PER_S = 48, 600.0
"""Degree of the polynomial in log frequency that replaces many frequencies, and the offset of the frequency."""
RINGS: Final = ((1 - 3**-0.5) / 2) ** 0.5, ((1 + 3**-0.5) / 2) ** 0.5
"""Radii of two rings of six places; the mean over these places is the mean over a disc of radius 1."""


@checked
@dataclass(frozen=True)
class Tissue:
    """A Kelvin-Voigt solid of shear modulus G + eta s.

    Parameters
    ----------
    density_kg_per_m3, sound_speed_m_per_s : float
        Textbook ranges of soft tissue: 1000 to 1100, 1500 to 1700.
    shear_modulus_pa : float
        Li et al. (2022) find Young's moduli of 40 and 15 kPa in the dermis and hypodermis of the forearm at 0.2 to 1
        kHz (abstract), of which a third is 13 and 5 kPa. It hardly matters above 1 kHz.
    shear_viscosity_pa_s : float
        15 by von Gierke and Oestreicher (from memory), less in other tissue at some kilohertz (no source for the pulp):
        an unverified default within 0.3 to 15.
    """

    density_kg_per_m3: Positive = 1050.0
    sound_speed_m_per_s: Positive = 1600.0
    shear_modulus_pa: NotNegative = 1e4
    shear_viscosity_pa_s: NotNegative = SHEAR_VISCOSITY_PA_S

    def __post_init__(self) -> None:
        found = f"{self.shear_modulus_pa} Pa and {self.shear_viscosity_pa_s} Pa s"
        expect(self.shear_modulus_pa + self.shear_viscosity_pa_s > 0, "Tissue.shear", found, "one of them above 0")

    def shear_pa(self, s: ComplexArray) -> ComplexArray:
        """Return the shear modulus at complex frequencies (rad/s)."""
        return np.asarray(self.shear_modulus_pa + self.shear_viscosity_pa_s * s)


@checked
@dataclass(frozen=True)
class PulpLoad:
    """A finger pulp that follows the mean motion of the plate over a disc.

    It does not follow the bending of the plate under the disc. Ridges, bone and nail are not modelled.

    Parameters
    ----------
    x_m, y_m : float
        Centre; all of the disc is on the plate.
    radius_m : float
        Above 0.
    tissue : Tissue
    """

    x_m: float
    y_m: float
    radius_m: Positive
    tissue: Tissue = field(default_factory=Tissue)

    def weights(self, screen: Screen, f_max_hz: float) -> FloatArray:
        """Return the mean of each mode shape over the disc, (n_modes,)."""
        self.check(screen.plate, "PulpLoad")
        return self.modal_force(screen.modes(f_max_hz))

    def modal_force(self, modes: Modes) -> FloatArray:
        """Return the generalised force of 1 N over the disc on each mode."""
        return np.asarray(values(modes, *np.transpose(self.points)).mean(axis=1))

    def check(self, plate: Plate, name: str) -> None:
        """Raise an error if part of the disc is not on the plate."""
        for point in self.points:
            plate.check_holds(name, point)

    def spread(self, s: ComplexArray, plate: Plate) -> FloatArray:
        """Return the mean over the disc of waves with amplitude 1 at its centre, (n,)."""
        from scipy.special import j0

        turned = self.radius_m * np.sqrt(np.abs(s.imag) / plate.wave_constant_m2_per_s)
        return np.asarray((j0(RINGS[0] * turned) + j0(RINGS[1] * turned)) / 2)

    @property
    def points(self) -> tuple[Point, ...]:
        """Return the places whose mean is the mean over the disc."""
        turns = [(self.radius_m * RINGS[n % 2], n * pi / 6) for n in range(12)]
        return tuple((self.x_m + far_m * cos(turn), self.y_m + far_m * sin(turn)) for far_m, turn in turns)

    def dynamic_stiffness(self, s: ComplexArray) -> ComplexArray:
        """Return the stiffness of the pulp (N/m) at complex s."""
        if len(s) <= DEGREE or np.ptp(s.real):
            return disc_stiffness(s, self.radius_m, self.tissue)
        slow, first, last = SLOW_RAD_PER_S, s[0].imag, s[-1].imag
        span = np.log((last + slow) / (first + slow))

        def scaled(place: FloatArray) -> Any:
            omega = (first + slow) * np.exp(span * (place + 1) / 2) - slow
            at = s[0].real + 1j * omega
            return disc_stiffness(at, self.radius_m, self.tissue) / (at + slow) ** 2

        place = 2 * np.log((s.imag + slow) / (first + slow)) / span - 1
        return np.asarray(chebval(place, chebinterpolate(scaled, DEGREE)) * (s + slow) ** 2)


@checked
def disc_stiffness(
    s: ComplexArray,
    radius_m: Positive,
    tissue: Tissue,
    *,
    n_pressures: Annotated[int, Ge(1)] = N_PRESSURES,
    path_factor: Annotated[float, Interval(ge=1, le=1024)] = 1.0,
) -> ComplexArray:
    """Return force per displacement of the disc at complex s, (n,).

    Parameters
    ----------
    s : (n,) array
        In the right half-plane or on its border, with an imaginary part of at least 0 (rad/s).
    n_pressures : int
        Number of pressure functions. `tactometry cost pulp-impedance` shows error and time.
    path_factor : float
        Factor of the length of the integration path, from 1 to 1024. The error falls with its square.

    >>> soft = Tissue(shear_modulus_pa=1e4)
    >>> disc_stiffness(np.array([1e-3j]), 6e-3, soft).real.round(1).tolist()
    [480.0]
    """
    shear = tissue.shear_pa(s)
    e = shear / (tissue.density_kg_per_m3 * tissue.sound_speed_m_per_s**2)
    with np.errstate(all="ignore"):  # NaN and infinity are rejected as too short a wave
        p = (s * radius_m / tissue.sound_speed_m_per_s) ** 2  # squares of the p and q above
        q = np.where(s == 0, 0.0, p / e)
    ends = _ends(np.sqrt(np.abs(q)), path_factor)
    total = np.empty(len(s), complex)
    for end in np.unique(ends).tolist():
        part = ends == end
        total[part] = _total(p[part], q[part], e[part], _bessel(end, n_pressures), *_path(end))
    return np.asarray(2 * pi * radius_m * shear * total)


def _total(
    p: ComplexArray, q: ComplexArray, e: ComplexArray, bessel: ComplexArray, x: ComplexArray, step: ComplexArray
) -> ComplexArray:
    """Return the weight of the first pressure where the surface moves by 1."""
    squares = x[:, None] ** 2
    alpha, beta = np.sqrt(squares + p), np.sqrt(squares + q)
    compliance = alpha / (q + 4 * squares * (1 - e) * beta / (alpha + beta))
    beyond_static = compliance - 1 / (2 * x[:, None] * (1 - e))

    n = np.arange(len(bessel))
    i, j = np.triu_indices(len(n))
    pairs = (bessel[i] * bessel[j] * (x * step)) @ beyond_static
    system = np.empty((len(p), len(n), len(n)), complex)
    system[:, i, j] = system[:, j, i] = pairs.T
    system[:, n, n] += pi / (2 * (4 * n + 1)) / (2 * (1 - e))[:, None]  # of the static part, exact
    moved_by_one = np.broadcast_to(np.eye(len(n))[:, :1], (len(p), len(n), 1))
    return np.asarray(np.linalg.solve(system, moved_by_one)[:, 0, 0])


def _ends(shear_waves: FloatArray, path_factor: float) -> FloatArray:
    """Return the ends of the path, powers of two; beyond them the static compliance holds."""
    most = float(shear_waves.max(initial=0.0))
    expected = f"at most {MOST_SHEAR:g} radii in shear waves; raise the shear viscosity or lower the frequency"
    expect(most <= MOST_SHEAR, "disc_stiffness: s, radius_m", f"{most:.3g}", expected)
    return np.asarray(2 ** np.ceil(np.log2(path_factor * np.maximum(SHEAR_WAVES * shear_waves, SHORTEST_PATH))))


@lru_cache(maxsize=16)
def _path(end: float) -> tuple[ComplexArray, ComplexArray]:
    """Return nodes above the real axis from 0, and their steps."""
    edges = np.concatenate([[0.0, 1e-3, 1e-2, 0.1, 0.3, 1.0], np.arange(2.0, end + PANEL, PANEL)])
    at, weight = leggauss(NODES)
    half = np.diff(edges)[:, None] / 2
    t, step = ((edges[:-1, None] + half) + half * at).ravel(), (half * weight).ravel()
    rising = np.tanh(t)
    return t + 1j * RISE * rising, step * (1 + 1j * RISE * (1 - rising**2))


@lru_cache(maxsize=16)
def _bessel(end: float, n_pressures: int) -> ComplexArray:
    """Return the spherical Bessel functions of even order, (n_pressures, n_nodes)."""
    from scipy.special import spherical_jn

    return np.stack([spherical_jn(2 * n, _path(end)[0]) for n in range(n_pressures)])
