"""Local loads on the plate as a low-rank update in the frequency domain.

With H the receptances and Z the dynamic stiffness of k contacts, H_rs' = H_rs - H_rc Z (I + H_cc Z)^-1 H_cs. It is
written as H_rc a (b + H_cc a)^-1 H_cs with a = Z / (1 + |Z| h) and b = 1 / (1 + |Z| h), h the magnitude of H_cc. This
is exact for Z = 0 and, with b = 0, for a rigid support, and needs no inverse of Z that could overflow.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Protocol, runtime_checkable

import numpy as np

from tactometry.arguments.checked import NotNegative, Positive, Unbounded, UnboundedComplex, checked
from tactometry.arguments.require import expect, shape, whole
from tactometry.errors import InvalidParameter

from ...arrays import ComplexArray, FloatArray, fast_length, real_product
from ..plate.oscillators import Oscillators
from ..plate.plate import Plate
from ..screen.screen import Screen
from .responses import Point, Responses, impulse_responses, values_at

WRAP_AROUND: Final = 1e-8
"""Remainder of the response after one period of the discrete transform."""

CHUNK: Final = 256
"""Frequencies per chunk: the motion of some hundred modes fits into the cache."""

RECEPTANCES_AT_ONCE: Final = 2**20
"""Pairs of contacts times frequencies per chunk, 16 MB: one frequency for a thousand contacts."""

WEIGHTS_AT_ONCE: Final = 2**14
"""Pairs of contacts per product of modal weights."""

COINCIDENT_PINS: Final = "loads: found pinned contacts that coincide, expected one per point"


@runtime_checkable
class Attached(Protocol):
    """Interface of a load: one motion of the plate causes one generalised force."""

    def weights(self, screen: Screen, f_max_hz: float) -> FloatArray:
        """Return the motion of the contact in each mode, (n_modes,)."""

    def dynamic_stiffness(self, s: ComplexArray) -> ComplexArray:
        """Return force per motion (n_frequencies,) at complex s (rad/s)."""


@runtime_checkable
class Placed(Attached, Protocol):
    """Something attached around a place, which answers the mean motion of points."""

    @property
    def x_m(self) -> float: ...

    @property
    def y_m(self) -> float: ...

    @property
    def points(self) -> tuple[Point, ...]:
        """Points whose mean motion is answered."""

    def spread(self, s: ComplexArray, plate: Plate) -> FloatArray:
        """Return the mean over the points of waves of 1 at the place, (n,)."""


@checked
@dataclass(frozen=True)
class PlateLoad:
    """A mass, a damper and a spring to ground at one point of the plate.

    Parameters
    ----------
    x_m, y_m : float
    resistance_n_s_per_m, mass_kg : float
        Damper and mass, at least 0.
    stiffness_n_per_m : float
        Spring, at least 0; ``math.inf`` pins the point.
    """

    x_m: float
    y_m: float
    resistance_n_s_per_m: NotNegative = 0.0
    mass_kg: NotNegative = 0.0
    stiffness_n_per_m: Unbounded = 0.0

    def __post_init__(self) -> None:
        expected = "at least 0, or inf for a pin"
        expect(self.stiffness_n_per_m >= 0, "PlateLoad.stiffness_n_per_m", self.stiffness_n_per_m, expected)

    @property
    def points(self) -> tuple[Point, ...]:
        """The place."""
        return ((self.x_m, self.y_m),)

    def spread(self, s: ComplexArray, plate: Plate) -> FloatArray:
        """Return 1: the motion is that of the place."""
        return np.ones(len(s))

    def weights(self, screen: Screen, f_max_hz: float) -> FloatArray:
        """Return the mode shapes at the contact, (n_modes,)."""
        screen.plate.check_holds("PlateLoad", (self.x_m, self.y_m))
        return values_at(screen, [(self.x_m, self.y_m)], f_max_hz)[:, 0]

    def dynamic_stiffness(self, s: ComplexArray) -> ComplexArray:
        """Return m s^2 + R s + k (N/m) at complex s, infinite for a pin."""
        return self.mass_kg * s**2 + self.resistance_n_s_per_m * s + self.stiffness_n_per_m


@checked
@dataclass(frozen=True)
class SprungMass:
    """A free mass on a spring at a point: rigidly coupled far below its resonance, a spring far above it.

    Parameters
    ----------
    x_m, y_m : float
    mass_kg, stiffness_n_per_m : float
        Mass and spring, above 0.
    """

    x_m: float
    y_m: float
    mass_kg: Positive
    stiffness_n_per_m: Positive

    @property
    def points(self) -> tuple[Point, ...]:
        """The place."""
        return ((self.x_m, self.y_m),)

    def spread(self, s: ComplexArray, plate: Plate) -> FloatArray:
        """Return 1: the motion is that of the place."""
        return np.ones(len(s))

    def weights(self, screen: Screen, f_max_hz: float) -> FloatArray:
        """Return the mode shapes at the contact, (n_modes,)."""
        screen.plate.check_holds("SprungMass", (self.x_m, self.y_m))
        return values_at(screen, [(self.x_m, self.y_m)], f_max_hz)[:, 0]

    def dynamic_stiffness(self, s: ComplexArray) -> ComplexArray:
        """Return 1 / (1 / k + 1 / (m s^2)) (N/m), spring and mass in series."""
        inertia = self.mass_kg * s**2
        return self.stiffness_n_per_m * inertia / (self.stiffness_n_per_m + inertia)


@checked
@dataclass(frozen=True, eq=False)
class Receptances:
    """Displacement per force between sets of modal weights, on a grid of complex frequencies.

    The reciprocal denominators 1 / (M (s^2 + 2 a s + w^2)) are computed once for all pairs.
    """

    compliance: ComplexArray

    @classmethod
    def of(cls, oscillators: Oscillators, mass_kg: Positive, s: ComplexArray) -> "Receptances":
        """Compute `compliance` (n_modes, n_frequencies) of oscillators."""
        return cls(oscillators.compliance(mass_kg, s))

    def between(self, to: FloatArray, of: FloatArray) -> ComplexArray:
        """Return receptances from weights (n_modes, n_to) and (n_modes, n_of)."""
        self._check(to=to, of=of)
        return self._pairs(to[:, :, None] * of[:, None, :])

    def correction(self, to: FloatArray, of: FloatArray, at: FloatArray, stiffness: UnboundedComplex) -> ComplexArray:
        """Return the reduction of `between(to, of)` by contacts.

        With T = H_rc a (b + H_cc a)^-1 it is the sum over modes of of_n (sum_k at_nk T_k) / (M (s^2 + 2 a s + w^2)):
        n_to n_of pairs, while H_cs alone needs k n_of. The smaller of `to` and `of` is carried along.

        Raises `InvalidParameter` if pinned contacts coincide.

        Parameters
        ----------
        at : (n_modes, k) array
            Modal weights of the contacts.
        stiffness : (n_frequencies, k) array
            Dynamic stiffness of each; infinite pins it.
        """
        self._check(to=to, of=of, at=at)
        if of.shape[1] < to.shape[1]:
            return self.correction(of, to, at, stiffness).swapaxes(0, 1)
        n_frequencies, k = self.compliance.shape[1], at.shape[1]
        shape("Receptances.correction.stiffness", stiffness, (n_frequencies, k))
        out = np.empty((to.shape[1], of.shape[1], n_frequencies), complex)
        step = max(1, RECEPTANCES_AT_ONCE // max(k, 1) ** 2)
        for start in range(0, n_frequencies, step):
            part = slice(start, start + step)
            Receptances(self.compliance[:, part])._take(to, of, at, stiffness[part], out[:, :, part])
        return out

    def _take(
        self, to: FloatArray, of: FloatArray, at: FloatArray, stiffness: UnboundedComplex, out: ComplexArray
    ) -> None:
        for toward, taken in zip(contact_transfer(self.between(to, at), self.among(at), stiffness), out, strict=True):
            for start in range(0, len(stiffness), CHUNK):
                part = slice(start, start + CHUNK)
                taken[:, part] = real_product(of.T, real_product(at, toward[:, part]) * self.compliance[:, part])

    def among(self, at: FloatArray) -> ComplexArray:
        """Return `between(at, at)` (n_frequencies, k, k), each pair computed once."""
        self._check(at=at)
        k = at.shape[1]
        among = np.empty((self.compliance.shape[1], k, k), complex)
        i, j = np.triu_indices(k)
        for start in range(0, len(i), WEIGHTS_AT_ONCE):
            left, right = i[start : start + WEIGHTS_AT_ONCE], j[start : start + WEIGHTS_AT_ONCE]
            among[:, left, right] = among[:, right, left] = self._pairs(at[:, left] * at[:, right]).T
        return among

    def _check(self, **weights: FloatArray) -> None:
        for name, of_modes in weights.items():
            shape(name, of_modes, (len(self.compliance), None))

    def _pairs(self, weights: FloatArray) -> ComplexArray:
        """Return (..., n_frequencies) from weights (n_modes, ...) of pairs."""
        flat = weights.reshape(len(weights), math.prod(weights.shape[1:]))
        return real_product(flat.T, self.compliance).reshape(*weights.shape[1:], self.compliance.shape[1])


@checked
def contact_transfer(to_contacts: ComplexArray, among: ComplexArray, stiffness: UnboundedComplex) -> ComplexArray:
    """Return H_rc a (b + H_cc a)^-1, (n_to, k, n_frequencies).

    Raises `InvalidParameter` if pinned contacts coincide.

    Parameters
    ----------
    to_contacts : (n_to, k, n_frequencies) array
        H_rc.
    among : (n_frequencies, k, k) array
        H_cc.
    stiffness : (n_frequencies, k) array
        Dynamic stiffness of each contact; infinite pins it.
    """
    shape("contact_transfer.to_contacts", to_contacts, (None, None, None))
    n_contacts, n_frequencies = to_contacts.shape[1:]
    shape("contact_transfer.among", among, (n_frequencies, n_contacts, n_contacts))
    shape("contact_transfer.stiffness", stiffness, (n_frequencies, n_contacts))
    a, b = _balance(stiffness, np.abs(np.einsum("fkk->fk", among)))
    system = among * a[:, None, :]
    np.einsum("fkk->fk", system)[...] += b  # a view on the diagonals
    try:
        # X (b + H a) = T a is solved in transposed form
        turned = np.linalg.solve(system.transpose(0, 2, 1), (to_contacts * a.T).transpose(2, 1, 0))
    except np.linalg.LinAlgError as error:
        raise InvalidParameter(COINCIDENT_PINS) from error
    return np.ascontiguousarray(turned.transpose(2, 1, 0))


@checked
def loaded_responses(
    screen: Screen,
    points: Sequence[Point],
    loads: Sequence[Attached],
    *,
    rate_hz: float,
    duration_s: float,
    f_max_hz: float,
) -> Responses:
    """Return displacement responses with loads on the plate.

    The unloaded part is the exact sum over modes. Only the correction uses a discrete transform, on the contour s =
    sigma + i w, which is regular without attenuation and has no wrap-around. The correction of a damper falls with the
    third power of frequency, that of a pin with the second. The part above the Nyquist frequency is up to 3 % and close
    to that frequency, so limit the band afterwards.

    >>> from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE
    >>> sampling = {"rate_hz": 50e3, "duration_s": 1e-3, "f_max_hz": 10e3}
    >>> free = impulse_responses(A4_PROTOTYPE, [(0.1, 0.1)], **sampling)
    >>> same = loaded_responses(A4_PROTOTYPE, [(0.1, 0.1)], [PlateLoad(0.1, 0.1, 0.0)], **sampling)
    >>> bool((same.samples == free.samples).all())
    True
    """
    free = impulse_responses(screen, points, rate_hz=rate_hz, duration_s=duration_s, f_max_hz=f_max_hz)
    if not loads or free.n_samples == 0:
        return free
    points_loaded = [load for load in loads if isinstance(load, PlateLoad)]
    pins = [(load.x_m, load.y_m) for load in points_loaded if math.isinf(load.stiffness_n_per_m)]
    if len(set(pins)) < len(pins):
        raise InvalidParameter(COINCIDENT_PINS)

    s, growth, n_fft = contour(free.n_samples, rate_hz)
    receptances = Receptances.of(screen.oscillators(f_max_hz), screen.plate.mass_kg, s)
    at = np.stack([load.weights(screen, f_max_hz) for load in loads], axis=1)
    stiffness = np.stack([load.dynamic_stiffness(s) for load in loads], axis=1)
    to, of = values_at(screen, points, f_max_hz), screen.modal_forces(f_max_hz)
    taken = receptances.correction(to, of, at, stiffness)
    correction = np.fft.irfft(taken, n_fft)[..., : free.n_samples] * growth
    return replace(free, samples=free.samples - correction)


@checked
def contour(n_samples: int, rate_hz: Positive) -> tuple[ComplexArray, FloatArray, int]:
    """Return complex frequencies, the growth factor of their shift and n_fft."""
    whole("contour", lowest=1, n_samples=n_samples)
    n_fft = fast_length(2 * n_samples)
    shift = -math.log(WRAP_AROUND) * rate_hz / n_fft  # sigma: exp(-sigma t) decays to this part in one period
    s = np.asarray(shift + 2j * np.pi * np.fft.rfftfreq(n_fft, 1 / rate_hz), complex)
    return s, np.asarray(np.exp(shift * np.arange(n_samples) / rate_hz), float), n_fft


def _balance(stiffness: ComplexArray, size: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Return A = Z / (1 + |Z| h) and b = 1 / (1 + |Z| h), finite for any Z."""
    pinned = np.isinf(stiffness)
    finite = np.where(pinned, 0.0, stiffness)
    scale = 1 / (1 + np.abs(finite) * size)
    a = np.where(pinned, 1 / np.where(size > 0, size, 1.0), finite * scale)
    return a, np.where(pinned & (size > 0), 0.0, scale).astype(complex)
