"""Motion of a plate under an emission, on complex frequencies.

A band-limited emission moves every mode by its receptance at any sampling rate. The contour s = sigma + i w of
`tactometry.stimuli.time_reversal.responses.load` makes this valid without attenuation and avoids wrap-around.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tactometry.arguments.require import expect

from ...arrays import ComplexArray, FloatArray, real_product
from ...time_reversal.plate.modes import Modes, values
from ...time_reversal.plate.oscillators import Oscillators
from ...time_reversal.responses.load import CHUNK, contour
from ...time_reversal.screen.screen import Screen
from ...time_reversal.screen.transducer import PointForce
from .emission import EmittedSignal, Points


@dataclass(frozen=True, eq=False)
class PlateMotion:
    """Displacement per volt of a plate, on complex frequencies.

    Parameters
    ----------
    screen : Screen
    modes_to_hz, static_to_hz : float
        Modes up to the first frequency move. Modes up to the second follow statically, with inertia to first order.
    amplitude : (n_modes, n_frequencies) array
        Amplitudes of the moving modes (m/V).
    played : (n_channels, n_frequencies) array
    s : (n_frequencies,) array
        Complex frequencies (rad/s); `n_fft` of them span the full circle at `rate_hz`.
    focus, n_samples : int
        Sample of the focus, and number of samples.
    """

    screen: Screen
    modes_to_hz: float
    static_to_hz: float
    amplitude: ComplexArray
    played: ComplexArray
    s: ComplexArray
    n_fft: int
    rate_hz: float
    focus: int
    n_samples: int

    @property
    def modes(self) -> Modes:
        """The moving modes, followed by those that respond statically."""
        return self.screen.modes(self.static_to_hz)

    def among(self, part: slice) -> "PlateMotion":
        """Return the motion at a slice of the frequencies."""
        return replace(self, amplitude=self.amplitude[:, part], played=self.played[:, part], s=self.s[part])

    def turning(self, t_s: FloatArray) -> ComplexArray:
        """Return the factors that bring spectra to times from the focus."""
        t_begin_s = self.focus / self.rate_hz + t_s
        turning: ComplexArray = np.exp(np.outer(self.s, t_begin_s)) * (2 / self.n_fft)
        turning[0] /= 2  # every other frequency also counts for its negative
        return turning

    def at_times(self, t_s: FloatArray) -> FloatArray:
        """Return every mode at times from the focus (m/V), (n_modes, n_times)."""
        turning = self.turning(t_s)
        still, pushed = self.following, _real(self.played, turning)
        hastened = _real(self.played, turning * self.s[:, None] ** 2)
        stiffness = self.stiffness_n_per_m[:, None] / self.screen.plate.mass_kg
        return np.vstack([_real(self.amplitude, turning), still @ pushed - still / stiffness @ hastened])

    def of_points(self, points: Points) -> ComplexArray:
        """Return displacement spectra of points, (n_points, n_frequencies)."""
        place = np.asarray(points, float)
        shapes = values(self.modes, place[:, 0], place[:, 1]).T
        n = len(self.amplitude)
        still = shapes[:, n:] @ self.following + self._beyond(points)
        inert = shapes[:, n:] @ (self.following / self.stiffness_n_per_m[:, None]) * self.screen.plate.mass_kg
        moved = real_product(shapes[:, :n], self.amplitude) + real_product(still, self.played)
        return moved - real_product(inert, self.played * self.s**2)

    def course(self, spectrum: ComplexArray, oversampling: int) -> FloatArray:
        """Return the course (..., n) of a spectrum, oversampled."""
        n = (self.n_samples - 1) * oversampling + 1
        damped = oversampling * np.fft.irfft(spectrum, self.n_fft * oversampling)[..., :n]
        # the contour is shifted by sigma, which damps all signals in time
        growth = np.exp(self.s[0].real / (oversampling * self.rate_hz) * np.arange(n))
        return np.asarray(damped * growth)

    def times_s(self, oversampling: int) -> FloatArray:
        """Return the times (n,) of a course, 0 at the focus instant."""
        n = (self.n_samples - 1) * oversampling + 1
        return (np.arange(n) - self.focus * oversampling) / (oversampling * self.rate_hz)

    def strain_energy_j(self, static_to_hz: float) -> float:
        """Return half the sum of M w^2 q^2 at the focus instant (J/V^2)."""
        further = replace(self, static_to_hz=static_to_hz)
        omega = further.modes.angular_frequency_rad_per_s
        q = further.at_times(np.zeros(1))[:, 0]
        return 0.5 * self.screen.plate.mass_kg * float(np.sum((omega * q) ** 2))

    @cached_property
    def stiffness_n_per_m(self) -> FloatArray:
        """Modal stiffness (n_following,) of the modes that follow statically."""
        return self.screen.plate.mass_kg * self.modes.angular_frequency_rad_per_s[len(self.amplitude) :] ** 2

    @cached_property
    def following(self) -> FloatArray:
        """Return the static displacement (m/V) of the modes that follow."""
        return self.screen.modal_forces(self.static_to_hz)[len(self.amplitude) :] / self.stiffness_n_per_m[:, None]

    def _beyond(self, points: Points) -> FloatArray:
        """Return the contribution of higher modes at the point of a force."""
        plate = self.screen.plate
        tail_m_per_n = plate.modal_density_s / (4 * np.pi**2 * plate.mass_kg * self.static_to_hz)
        places = [
            (source.x_m, source.y_m) if isinstance(source, PointForce) else None for source in self.screen.sources
        ]
        return tail_m_per_n * np.array([[place == tuple(point) for place in places] for point in points], float)


def moving_modes(screen: Screen, modes_to_hz: float, static_to_hz: float) -> tuple[Oscillators, FloatArray]:
    """Return the moving oscillators and their forces (n_modes, n_channels).

    They are returned together, as the sign of a Ritz mode may differ between solutions.
    """
    every = screen.oscillators(static_to_hz)
    n = int(np.searchsorted(every.omega_rad_per_s, 2 * np.pi * modes_to_hz, side="right"))
    return Oscillators(every.omega_rad_per_s[:n], every.decay_per_s[:n]), screen.modal_forces(static_to_hz)[:n]


def plate_motion(
    screen: Screen,
    emission: EmittedSignal,
    *,
    modes_to_hz: float,
    static_to_hz: float,
    heard_to_hz: float,
    after_s: float,
) -> PlateMotion:
    """Compute the motion up to `heard_to_hz` and `after_s` past the focus."""
    expected = f"at least modes_to_hz, {modes_to_hz}"
    expect(static_to_hz >= modes_to_hz, "settings.motion.static_to_hz", static_to_hz, expected)
    n_played, rate_hz = emission.samples.shape[1], emission.rate_hz
    n = max(emission.focus + 1 + round(after_s * rate_hz), n_played)
    s, growth, n_fft = contour(n, rate_hz)
    s = s[: int(heard_to_hz * n_fft / rate_hz) + 1]
    played = np.fft.rfft(emission.samples / growth[:n_played], n_fft)[:, : len(s)]
    oscillators, forces = moving_modes(screen, modes_to_hz, static_to_hz)
    amplitude = answer(oscillators, screen.plate.mass_kg, s, lambda part: real_product(forces, played[:, part]))
    return PlateMotion(screen, modes_to_hz, static_to_hz, amplitude, played, s, n_fft, rate_hz, emission.focus, n)


def answer(
    oscillators: Oscillators, mass_kg: float, s: ComplexArray, push: Callable[[slice], ComplexArray | FloatArray]
) -> ComplexArray:
    """Return the modes under generalised forces, supplied in chunks by `push`.

    Intermediate results take no more memory than the modes.
    """
    amplitude = np.empty((len(oscillators.omega_rad_per_s), len(s)), complex)
    for start in range(0, len(s), CHUNK):
        part = slice(start, start + CHUNK)
        np.multiply(push(part), oscillators.compliance(mass_kg, s[part]), out=amplitude[:, part])
    return amplitude


def focus_value(motion: PlateMotion, foci: Points) -> FloatArray:
    """Return the displacement (m/V) of the foci at their instant, (n_foci,)."""
    return _real(motion.of_points(foci), motion.turning(np.zeros(1)))[:, 0]


def sampling(factor: int) -> int:
    """Return the oversampling of the courses relative to the clock."""
    return factor


def focus_course(motion: PlateMotion, foci: Points, oversampling: int) -> FloatArray:
    """Return the displacement of the first focus over time (m/V)."""
    return course_at(motion, oversampling, *foci[0])


def course_at(motion: PlateMotion, oversampling: int, x_m: float, y_m: float) -> FloatArray:
    """Return the displacement of a place over time (m/V)."""
    return motion.course(motion.of_points(((x_m, y_m),))[0], oversampling)


def _real(numbers: ComplexArray, turning: ComplexArray) -> FloatArray:
    return np.asarray(numbers.real @ turning.real - numbers.imag @ turning.imag)


def along(side_m: float, n: int) -> FloatArray:
    """Return places along a side, from edge to edge."""
    return np.linspace(0.0, side_m, n)


def focus_field(motion: PlateMotion, x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    """Return the displacement (m/V) at the focus instant, (n_x, n_y)."""
    return motion.modes.field(motion.at_times(np.zeros(1))[:, 0], x_m, y_m)


def frame_times(n_frames: int, span_s: float) -> FloatArray:
    """Return the times of a movie's frames, with the focus in the middle."""
    return np.linspace(-span_s / 2, span_s / 2, n_frames)


def movie(motion: PlateMotion, frames_s: FloatArray, x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    """Return the displacement (m/V), (n_frames, n_x, n_y), at times."""
    draw = motion.modes.frame(x_m, y_m)
    return np.stack([draw(np.ascontiguousarray(amplitudes)) for amplitudes in motion.at_times(frames_s).T])
