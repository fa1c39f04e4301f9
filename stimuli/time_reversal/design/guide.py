"""The design guide for screens (thesis 3.5).

It returns the predictions of closed forms for the recommended design (`OFF` states how far the simulation deviates).
For each target out of reach it states the reason and the necessary change. The rule T = 2 tau <= T_r (86 % of the 1-bit
amplitude) is our own, as we did not find the thesis's recommendation.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from tactometry.arguments.checked import Positive, Vector, checked
from tactometry.arguments.require import expect, positive

from ...arrays import FloatArray
from ..filters import Band
from ..plate.dispersion import group_velocity_m_per_s, wavenumber_rad_per_m
from ..plate.plate import Plate
from ..plate.statics import bending_stress_pa
from ..screen.transducer import MOMENT_N_PER_V, SIDE_M, VOLTAGE_V
from .closed_forms import (
    Reverberation,
    contrast_limit,
    contrast_whole,
    effective_hz,
    one_bit_amplitude_ratio,
    passed_hz,
    repetition_amplitude_ratio,
    repetition_noise_ratio,
    resolution_m,
    weighted_width_m,
)

OFF: Final[Mapping[str, tuple[float, float]]] = {
    "resolution": (-0.15, 0.10),
    "contrast": (-0.25, 0.15),
    "amplitude": (-0.25, 0.15),
}
"""Least and largest relative deviation of the simulation from the law, averaged over four foci in the middle of the
plate.

Measured on 520 screens: glass of 297 x 210 and 210 x 148 mm, 0.3 to 4 mm thick, edges supported, 8 to 64 patches of 2
to 10 mm in a row 12 mm from the edge, tau of 1 to 8 ms, T of 0.5 to 4 tau, bands from 1-10 to 36-108 kHz, if the field
is diffuse (`Design.is_diffuse`). Nine of ten screens are within -8 to 4 %, -13 to 4 % and -14 to 5 %.
"""

FEWEST_CROSSINGS: Final = 3.0
FEWEST_MODES: Final = 40.0
MAX_TRANSDUCERS: Final = 256
STRESS_MAX_PA: Final = 20e6
"""Long-term limit of the bending stress of annealed glass under a finger; unverified default."""

FINGER_FORCE_N: Final = 2.0
FINGER_DIAMETER_M: Final = 10e-3


@checked
@dataclass(frozen=True)
class Transducers:
    """Square patches of side `side_m` (m) with a moment (N per V), driven with one bit at `voltage_v`."""

    n: int = 32
    side_m: float = SIDE_M
    moment_n_per_v: float = MOMENT_N_PER_V
    voltage_v: float = VOLTAGE_V

    def __post_init__(self) -> None:
        positive("Transducers", **vars(self))


@checked
@dataclass(frozen=True)
class Target:
    """Design targets, None for a quantity without a target.

    Parameters
    ----------
    resolution_m : float, optional
        Largest full width at -6 dB.
    contrast : float, optional
        Smallest `closed_forms.contrast_whole`.
    amplitude_m : float, optional
        Smallest displacement at the focus without a finger.
    repetition_hz : float, optional
        Number of foci per second.
    """

    resolution_m: Positive | None = None
    contrast: Positive | None = None
    amplitude_m: Positive | None = None
    repetition_hz: Positive | None = None


@checked
@dataclass(frozen=True)
class Design:
    """The parameters of a screen that the closed forms need."""

    plate: Plate
    transducers: Transducers
    band: Band
    tau_s: Positive
    reversal_s: Positive
    repetition_s: Positive | None = None

    def __post_init__(self) -> None:
        held = n_held(self.plate, self.transducers.side_m)
        found = f"{self.transducers.n} patches of {self.transducers.side_m * 1e3:.3g} mm"
        expected = f"at most {held} along the edges of the plate; use fewer or smaller ones"
        expect(self.transducers.n <= held, "Transducers", found, expected)

    @property
    def noise_ratio(self) -> float:
        """Residual noise power of the repeated focus over that of one."""
        return 1.0 if self.repetition_s is None else float(repetition_noise_ratio(self.repetition_s, self.tau_s))

    @property
    def overlap_ratio(self) -> float:
        """Part of the amplitude that remains if drives overlap."""
        if self.repetition_s is None or self.repetition_s >= self.reversal_s:
            return 1.0
        return repetition_amplitude_ratio(self.reversal_s, self.repetition_s, self.tau_s)

    @property
    def reverberation(self) -> Reverberation:
        """Reverberation with N_eff = n_f (int W^2)^2 / int W^4 weighted modes."""
        return Reverberation(
            self.transducers.n, effective_hz(*self._weighting), self.tau_s, self.reversal_s, self.plate.modal_density_s
        )

    @property
    def n_crossings(self) -> float:
        """Number of crossings of the plate by waves within T and tau."""
        speed_m_per_s = float(group_velocity_m_per_s(self.plate, self.band.mean_hz))
        return speed_m_per_s * min(self.reversal_s, self.tau_s) / math.sqrt(self.plate.area_m2)

    @property
    def is_diffuse(self) -> bool:
        """True if the field is diffuse enough for the laws, as `OFF` states.

        Waves must cross the plate often enough, and the band must contain enough modes.
        """
        return self.n_crossings >= FEWEST_CROSSINGS and self.reverberation.n_modes >= FEWEST_MODES

    @property
    def resolution_m(self) -> float:
        """Full width at -6 dB, weighted by the patches."""
        return weighted_width_m(*self._weighting)

    @property
    def _weighting(self) -> tuple[Plate, float, Band]:
        return self.plate, self.transducers.side_m, self.band

    @property
    def contrast(self) -> float:
        """Contrast of the weighted modes with the noise of repetition."""
        return contrast_whole(self.reverberation) / math.sqrt(self.noise_ratio)

    @property
    def amplitude_m(self) -> float:
        """Expected focus amplitude of the 1-bit drive in a diffuse field.

        A = V Q sqrt(2/pi) tau (1 - exp(-T/tau)) sigma with sigma^2 = n_f / 2 (m A_p / (M c))^2 times the integral of
        W^2 over the band; W is the low-pass of the patch, averaged over directions. Our derivation; see `OFF`. If
        drives overlap (T above T_r), `closed_forms.repetition_amplitude_ratio` scales it.
        """
        plate, patches = self.plate, self.transducers
        push = patches.moment_n_per_v * patches.side_m**2 / (plate.mass_kg * plate.wave_constant_m2_per_s)
        sigma = push * math.sqrt(plate.modal_density_s / 2 * passed_hz(*self._weighting))
        ring_s = self.tau_s * float(one_bit_amplitude_ratio(self.reversal_s, self.tau_s))
        return patches.voltage_v * patches.n * math.sqrt(2 / math.pi) * ring_s * sigma * self.overlap_ratio


@checked
@dataclass(frozen=True)
class Guide:
    """The recommended design, and the targets out of reach with reasons."""

    design: Design
    unreachable: tuple[str, ...]
    notes: tuple[str, ...]


@checked
def recommend(plate: Plate, transducers: Transducers, band: Band, tau_s: Positive, target: Target) -> Guide:
    """Choose T, T_r, Q and band for a target, with the least changes.

    Parameters
    ----------
    plate, transducers, band, tau_s
        The available screen. Q is raised as contrast and amplitude require, and the band is moved up as resolution
        requires. The thickness is kept: `thickness.sheets` and `best_sheet` choose it.
    target : Target

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> target = Target(contrast=15.0, repetition_hz=100.0)
    >>> guide = recommend(A4_SCREEN, Transducers(), Band(20e3, 60e3), 3.5e-3, target)
    >>> guide.unreachable
    ()
    >>> guide.design.reversal_s
    0.007
    """
    repetition_s = None if target.repetition_hz is None else 1 / target.repetition_hz
    reversal_s = 2 * tau_s if repetition_s is None else min(2 * tau_s, repetition_s)
    start = Design(plate, transducers, band, tau_s, reversal_s, repetition_s)
    sharp, unsharp, notes = _for_resolution(start, target.resolution_m)
    clear, unclear = _for_contrast(sharp, target.contrast)
    strong, weak = _for_amplitude(clear, target.amplitude_m)
    unreachable = (*unsharp, *unclear, *weak, *_too_fast(strong))
    return Guide(strong, unreachable, (*notes, _about_time(strong), _about_stress(plate), *_about_laws(strong)))


@checked
def amplitudes_m(design: Design, reversal_s: Vector) -> FloatArray:
    """Return the amplitude (m) for reversal times."""
    return np.array([replace(design, reversal_s=float(t)).amplitude_m for t in reversal_s])


@checked
def contrast_over(design: Design, n_channels: Vector, reversal_s: Vector) -> FloatArray:
    """Return the contrast for numbers of channels and reversal times."""
    room = design.reverberation
    return np.array(
        [
            [contrast_whole(replace(room, n_channels=int(q), reversal_s=float(t))) for t in reversal_s]
            for q in n_channels
        ]
    ) / math.sqrt(design.noise_ratio)


@checked
def n_held(plate: Plate, side_m: Positive) -> int:
    """Return how many patches fit in one row along the edges, or 0.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> n_held(A4_SCREEN, 35e-3)
    24
    """
    room_m = (plate.length_m - side_m, plate.width_m - side_m)
    return 0 if min(room_m) < 0 else max(1, 2 * sum(math.floor(room / side_m + 1e-9) for room in room_m))


@checked
def thickness_for_m(plate: Plate, band: Band, wanted_resolution_m: float) -> float:
    """Return the thickness (m) that a resolution needs with small patches."""
    return plate.thickness_m * (wanted_resolution_m / resolution_m(plate, band)) ** 2


def _for_resolution(design: Design, wanted_m: float | None) -> tuple[Design, tuple[str, ...], tuple[str, ...]]:
    if wanted_m is None or design.resolution_m <= wanted_m:
        return design, (), ()
    factor = (resolution_m(design.plate, design.band) / wanted_m) ** 2
    thin_m = thickness_for_m(design.plate, design.band, wanted_m)
    advice = (
        f"resolution: {wanted_m * 1e3:.3g} mm instead of {design.resolution_m * 1e3:.3g} mm needs (with patches "
        f"far smaller than the wave) a mean frequency of {design.band.mean_hz * factor / 1e3:.3g} kHz or a plate of "
        f"{thin_m * 1e3:.2g} mm"
    )
    higher = _moved_up(design, wanted_m)
    if higher is not None:
        return higher, (), (f"{advice}; the band is moved up to {higher.band.mean_hz / 1e3:.3g} kHz",)
    reason = f"; in a higher band the wave is shorter than a patch of {design.transducers.side_m * 1e3:.3g} mm"
    return design, (advice + reason,), ()


def _moved_up(design: Design, wanted_m: float) -> Design | None:
    """Move the band up to the wanted resolution, if patches permit it."""
    from scipy.optimize import brentq

    def scaled(factor: float) -> Design:
        band = design.band
        return replace(design, band=Band(band.f_min_hz * factor, band.f_max_hz * factor, band.flank_hz))

    most = wavelength_to_patch(design.plate, design.band.f_max_hz, design.transducers.side_m) ** 2
    if most <= 1 or scaled(most).resolution_m > wanted_m:
        return None
    return scaled(float(brentq(lambda x: scaled(x).resolution_m - wanted_m, 1.0, most, xtol=1e-12)))


@checked
def wavelength_to_patch(plate: Plate, frequency_hz: Positive, side_m: Positive) -> float:
    """Return the ratio of wavelength to patch side."""
    return float(2 * math.pi / wavenumber_rad_per_m(plate, frequency_hz) / side_m)


def _for_contrast(design: Design, wanted: float | None) -> tuple[Design, tuple[str, ...]]:
    if wanted is None or design.contrast >= wanted:
        return design, ()
    room = design.reverberation
    limit = contrast_limit(room) / math.sqrt(design.noise_ratio)
    if wanted >= limit:
        needed_hz = design.band.width_hz * (wanted / limit) ** 2
        return design, (
            f"contrast: {wanted:.3g} is above sqrt(N) = {limit:.3g}, the limit for {room.n_modes:.0f} modes that the "
            "patches excite in the band at this repetition, whatever Q and T; widen the band beyond "
            f"{needed_hz / 1e3:.3g} kHz or use smaller patches or a larger or thinner plate",
        )
    needed = math.ceil((room.kurtosis + room.absorption) / ((limit / wanted) ** 2 - 1))
    refusal = (
        f"contrast: {wanted:.3g} needs {needed} transducers, more than {_most(design)} in a row along the edges; "
        "widen the band, or raise tau and T"
    )
    return _with_transducers(design, needed, refusal)


def _for_amplitude(design: Design, wanted_m: float | None) -> tuple[Design, tuple[str, ...]]:
    if wanted_m is None or design.amplitude_m >= wanted_m:
        return design, ()
    needed = math.ceil(design.transducers.n * wanted_m / design.amplitude_m)
    volts = design.transducers.voltage_v * wanted_m / design.amplitude_m
    refusal = (
        f"amplitude: {wanted_m * 1e6:.3g} um needs {needed} transducers, more than fit along the edges; "
        f"{design.transducers.n} of them reach it at {volts:.3g} V"
    )
    return _with_transducers(design, needed, refusal)


def _with_transducers(design: Design, needed: int, refusal: str) -> tuple[Design, tuple[str, ...]]:
    """Add transducers as needed if the edges have space for them."""
    if needed > _most(design):
        return design, (refusal,)
    return replace(design, transducers=replace(design.transducers, n=needed)), ()


def _most(design: Design) -> int:
    return min(MAX_TRANSDUCERS, n_held(design.plate, design.transducers.side_m))


def _too_fast(design: Design) -> tuple[str, ...]:
    repetition_s, shortest_s = design.repetition_s, 2 / design.band.width_hz
    if repetition_s is None or repetition_s >= shortest_s:
        return ()
    return (
        f"repetition: {1 / repetition_s:.3g} Hz leaves {repetition_s * 1e3:.3g} ms, less than two widths of a focus "
        f"({shortest_s * 1e3:.3g} ms for the bandwidth); repeat more slowly or widen the band",
    )


def _about_time(design: Design) -> str:
    share = float(one_bit_amplitude_ratio(design.reversal_s, design.tau_s))
    text = f"time: T = {design.reversal_s * 1e3:.3g} ms uses {share:.0%} of the amplitude of an endless reversal"
    if design.repetition_s is None:
        return text
    return f"{text}; repetition multiplies the residual noise power by {design.noise_ratio:.2g}"


def _about_stress(plate: Plate) -> str:
    stress_pa = bending_stress_pa(plate, FINGER_FORCE_N, FINGER_DIAMETER_M)
    verdict = "more than" if stress_pa > STRESS_MAX_PA else "within"
    return (
        f"stress: {FINGER_FORCE_N:.0f} N bend the plate (edges supported) with {stress_pa / 1e6:.2g} MPa, "
        f"{verdict} the {STRESS_MAX_PA / 1e6:.0f} MPa that glass bears permanently"
    )


def _about_laws(design: Design) -> tuple[str, ...]:
    if design.is_diffuse:
        return ()
    return (
        f"laws: in T and tau the waves cross the plate {design.n_crossings:.2g} times, and the band has "
        f"{design.reverberation.n_modes:.0f} modes; with fewer than {FEWEST_CROSSINGS:.0f} or {FEWEST_MODES:.0f} "
        "the field is not diffuse, and the laws may be off by half",
    )
