"""Sensation and displacement at a loaded place of a driven plate."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import inf
from typing import Final, Literal

import numpy as np

from tactometry.arguments.checked import NotNegative, Positive, Vector, checked
from tactometry.arguments.require import expect, shape
from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal

from ...arrays import ComplexArray, FloatArray, IntArray
from ...defaults import FOCUS_AT_THRESHOLD_M, FORCE_EXPONENT, RESISTANCE_N_S_PER_M
from ...perception.temporal_summation import summed_amplitude
from ..finger import FINGER_DIAMETER_M, Contactor
from ..fingertip import Fingertip
from ..focusing.focusing import emitted
from ..responses.load import Placed, PlateLoad, Receptances, SprungMass, contact_transfer, contour
from ..responses.responses import Point, impulse_responses, values_at
from .contact_force import contact_force_n
from .setup import Setup

Places = tuple[Point, ...]

N_CACHED: Final = 32
APART_S: Final = 1e-3
"""Foci closer in time than this are felt as one event; range: `events` in `stimuli/sources.toml`."""

STEADY_S: Final = 5e-3
"""Time over which reverberation counts as steady, about its time constant; range: `events` in
`stimuli/sources.toml`."""

NORMAL_MEDIAN: Final = 0.6745
"""Median magnitude of normal noise, divided by its standard deviation."""

FAINT: Final = 1e-9
"""Part of the largest magnitude below which values are rounding errors."""

READING_M: Final = 1e-9
"""One nanometre, the unit of a vibrometer's reading."""


@checked
@dataclass(frozen=True)
class TimeReversalSensation:
    """Settings of a scene of foci under a finger.

    `tactometry.stimuli.scenes.default_scenes.default_scene` builds the scene.

    The displacement under the finger is ultrasonic, which touch does not feel. Each focus is felt as one event that
    throws the skin off. The Pacinian channel sums the energy of a train over 0.2 s
    (`tactometry.stimuli.perception.temporal_summation`). The level is 20 log10 of the equivalent single focus re
    `reference_m`.

    Parameters
    ----------
    setup : Setup
        Screen and focus of the stimulus.
    reference_m : float
        Amplitude of a single focus at the detection threshold (the thesis: about 10 um).
    criterion : {"loaded", "unloaded"}
        ``unloaded``: the amplitude of the free plate counts, so that the threshold does not depend on force, as the
        thesis found. ``loaded``: the amplitude under the finger's load counts, exact for a linear contact. Lift-off
        does not decide between them, as `one_sided_contact` loses as much at the focus. Other authors find an effect of
        force on vibrations of some hundred hertz.
    resistance_n_s_per_m
        As in `Fingertip`, of the finger of ``loaded``.
    mass_kg
        As in `Fingertip`, of the finger of ``loaded``.
    stiffness_n_per_m
        As in `Fingertip`, of the finger of ``loaded``.
    exponent
        Growth of these three with force; the default finger takes 31 % of the amplitude at 2 N.
    finger_x_m : float, optional
        Place of the finger along the length. Default: at the focus.
    finger_y_m : float, optional
        Place of the finger along the width. Default: at the focus.

    >>> TimeReversalSensation(criterion="loaded").finger.load((0.1, 0.1), force_n=0.5).resistance_n_s_per_m
    5.0
    """

    setup: Setup = field(default_factory=Setup)
    reference_m: Positive = FOCUS_AT_THRESHOLD_M
    criterion: Literal["loaded", "unloaded"] = "unloaded"
    resistance_n_s_per_m: NotNegative = RESISTANCE_N_S_PER_M
    mass_kg: NotNegative = 0.0
    stiffness_n_per_m: NotNegative = 0.0
    exponent: float = FORCE_EXPONENT
    finger_x_m: float | None = None
    finger_y_m: float | None = None

    def __post_init__(self) -> None:
        place = place_on(self.setup, self.finger_x_m, self.finger_y_m)
        self.setup.plate.check_holds("TimeReversalSensation.finger_x_m, finger_y_m", place)

    @property
    def finger(self) -> Fingertip:
        """The pressing finger, and its load if the criterion is ``loaded``."""
        return Fingertip(self.resistance_n_s_per_m, self.mass_kg, self.stiffness_n_per_m, self.exponent)


@checked
@dataclass(frozen=True)
class FocusReading:
    """Largest displacement at the focus in dB re 1 nm with a contactor on the plate, as the `sensation_db` of a rig.

    Parameters
    ----------
    setup : Setup
        Screen and focus of the stimulus.
    contactor : {"finger", "soft", "rigid"}
        The pressing contactor: a finger, a soft or a rigid tip, as in `Contactor`.
    diameter_m : float
        Diameter of a soft or rigid contactor, above 0.
    x_m : float, optional
        Place of the finger along the length. Default: at the focus.
    y_m : float, optional
        Place of the finger along the width. Default: at the focus.

    >>> from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain
    >>> setup = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3)
    >>> signal = FocusTrain(setup, f_max_hz=20e3).at(20.0)
    >>> round(FocusReading(setup).sensation_db(signal, Contact(0.0)), 6)
    80.0
    >>> FocusReading(setup).sensation_db(signal, Contact(2.0)) < 79
    True
    """

    setup: Setup = field(default_factory=Setup)
    contactor: Literal["finger", "soft", "rigid"] = "finger"
    diameter_m: float = FINGER_DIAMETER_M
    x_m: float | None = None
    y_m: float | None = None

    def __post_init__(self) -> None:
        Contactor(self.contactor, self.diameter_m)
        self.setup.plate.check_holds("FocusReading.x_m, y_m", self.place_m)
        values_at(self.setup.screen, [self.place_m], self.setup.modes_to_hz)

    @property
    def place_m(self) -> Point:
        return place_on(self.setup, self.x_m, self.y_m)

    def sensation_db(self, signal: Signal, contact: Contact) -> float:
        """Return the reading in dB re 1 nm; ``-inf`` for no displacement."""
        displacement_m = displacement_at_focus_m(self.setup, signal, self._loads(contact))
        amplitude_m = float(np.abs(displacement_m).max(initial=0.0))
        return -inf if amplitude_m == 0 else float(20 * np.log10(amplitude_m / READING_M))

    def contact_force_n(self, signal: Signal, contact: Contact) -> FloatArray:
        """Return a linear contact's force minus the normal force, (n_samples,).

        For a disc it is the sum over the disc. Where this pulls by more than the normal force, the whole tip lifts off;
        a part may lift off earlier.
        """
        return contact_force_n(self.setup, signal, self._loads(contact))

    @property
    def pressers(self) -> tuple[str, ...]:
        """Descriptions of the pressing contacts."""
        return (self._presses.words,)

    @property
    def _presses(self) -> Contactor:
        return Contactor(self.contactor, self.diameter_m)

    def _loads(self, contact: Contact) -> list[PlateLoad | SprungMass]:
        return self._presses.loads(self.setup.screen.plate, self.place_m, contact.force_n)


@checked
def place_on(setup: Setup, x_m: float | None, y_m: float | None) -> Point:
    """Return a place on the screen, by default the focus."""
    at_x_m, at_y_m = setup.focus_m
    return at_x_m if x_m is None else x_m, at_y_m if y_m is None else y_m


@checked
def free_displacement(signal: Signal, setup: Setup, at_m: Point) -> FloatArray:
    """Return the free displacement at a place, (n_samples,).

    Raises `InvalidParameter` if the signal is not in volt, or its rate or channels are not those of the setup.
    """
    n_channels = signal.samples.shape[0]
    if signal.unit != "V" or n_channels != setup.n_transducers or signal.rate_hz != setup.rate_hz:
        raise InvalidParameter(
            f"signal: found {n_channels} channels in {signal.unit!r} at {signal.rate_hz:g} Hz, expected "
            f"{setup.n_transducers} in volt ('V') at {setup.rate_hz:g} Hz, as in the setup"
        )
    return np.asarray(emitted(signal, setup.responses_at(*at_m))[0])


@checked
def loaded_displacements(free_m: FloatArray, setup: Setup, loads: Sequence[Placed]) -> FloatArray:
    """Return U' = (1 + H Z)^-1 U at contacts, (n_loads, n_samples).

    The result is exact for linear contacts, which move the plate under each other. It is solved on the contour of
    `load.contour`, as in `load.loaded_responses`. A disc responds to the mean free motion over it, computed from that
    at its centre as for plane waves.
    """
    shape("loaded_displacements.free_m", free_m, (len(loads), None))
    if all(isinstance(load, PlateLoad) and load == PlateLoad(load.x_m, load.y_m) for load in loads):
        return free_m
    if any(len(load.points) > 1 for load in loads):
        return _under_discs(free_m, setup, tuple(loads))
    n = free_m.shape[1]
    s, growth, n_fft = contour(n, setup.rate_hz)
    stiffness = np.stack([load.dynamic_stiffness(s) for load in loads], axis=1)
    system = np.eye(len(loads)) + _among(setup, tuple((load.x_m, load.y_m) for load in loads), n) * stiffness[:, None]
    held = 1 / system if len(loads) == 1 else np.linalg.inv(system)
    spectrum = np.einsum("fij,jf->if", held, np.fft.rfft(free_m / growth, n_fft))
    return np.asarray(np.fft.irfft(spectrum, n_fft)[:, :n] * growth)


def _under_discs(free_m: FloatArray, setup: Setup, loads: tuple[Placed, ...]) -> FloatArray:
    n = free_m.shape[1]
    _, growth, n_fft = contour(n, setup.rate_hz)
    taken = np.einsum("akf,kf->af", _taken_by_discs(setup, loads, n), np.fft.rfft(free_m / growth, n_fft))
    return np.asarray(free_m - np.fft.irfft(taken, n_fft)[:, :n] * growth)


@lru_cache(maxsize=N_CACHED)
def _taken_by_discs(setup: Setup, loads: tuple[Placed, ...], n_samples: int) -> ComplexArray:
    """Return what loads take at the centres per free motion at each, (k, k, n_frequencies)."""
    s, _, _ = contour(n_samples, setup.rate_hz)
    receptances = _receptances_of(setup, n_samples)
    centres = values_at(setup.screen, [(load.x_m, load.y_m) for load in loads], setup.modes_to_hz)
    at = np.stack([load.weights(setup.screen, setup.modes_to_hz) for load in loads], axis=1)
    stiffness = np.stack([load.dynamic_stiffness(s) for load in loads], axis=1)
    toward = contact_transfer(receptances.between(centres, at), receptances.among(at), stiffness)
    return np.asarray(toward * np.stack([load.spread(s, setup.plate) for load in loads]))


@checked
def displacement_at_focus_m(setup: Setup, signal: Signal, loads: list[PlateLoad | SprungMass]) -> FloatArray:
    """Return U_f - H_fc Z (1 + H_cc Z)^-1 U_c at the focus, (n_samples,).

    U_f and U_c are the free plate's displacements at the focus and at the contacts. It is solved on the contour of
    `load.contour`, as in `load.loaded_responses`.
    """
    n = signal.samples.shape[1]
    places = tuple((load.x_m, load.y_m) for load in loads)
    free_m, at_contacts = _free(setup, signal, (setup.focus_m,)), _free(setup, signal, places)
    if not loads:
        return np.asarray(free_m[0])
    s, growth, n_fft = contour(n, setup.rate_hz)
    stiffness = np.stack([load.dynamic_stiffness(s) for load in loads], axis=1)
    toward = contact_transfer(*_between(setup, places, n), stiffness)[0]
    taken = np.einsum("kf,kf->f", toward, np.fft.rfft(at_contacts / growth, n_fft))
    return np.asarray(free_m[0] - np.fft.irfft(taken, n_fft)[:n] * growth)


@checked
def events(displacement_m: Vector, rate_hz: Positive) -> tuple[FloatArray, FloatArray]:
    """Return times (s) and magnitudes (m) of foci, at least 1 ms apart.

    The largest focus always counts. A smaller one counts if normal noise as strong as the surrounding reverberation
    would reach its height less than once in the course. The sign of a focus is not felt: it shifts the motion by half a
    period at some 10 kHz, and both signs throw the skin off.

    >>> events(np.array([0, 1.0, 0, 0, -3.0, 0, 0, 2.0, 0]), 1000.0)
    (array([0.001, 0.004, 0.007]), array([1., 3., 2.]))
    """
    magnitude = np.abs(np.concatenate([[0.0], displacement_m, [0.0]]))
    apart = max(round(APART_S * rate_hz), 1)
    largest = magnitude.max()
    height = np.clip(_reverberation_m(magnitude, rate_hz), FAINT * largest, largest)
    index = peaks(magnitude, height, apart)
    return np.asarray((index - 1) / rate_hz, float), np.asarray(magnitude[index])


@checked
def peaks(x: Vector, height: FloatArray | float, apart: int) -> IntArray:
    """Return the maxima of `x` of at least `height`.

    A flat maximum is placed at its middle. Of maxima closer than `apart`, the highest counts.

    `height` is a number, or an array with one value per sample.

    ``scipy.signal.find_peaks`` returns the same maxima, but its import takes longer than computing a scene.

    >>> peaks(np.array([0, 1.0, 0, 2, 2, 2, 0, 1.5, 0]), 1.0, 4).tolist()
    [4]
    """
    if np.ndim(height):
        shape("peaks.height", height, x.shape)
    high = np.flatnonzero((x >= height)[1:-1]) + 1
    rises, ends = high[x[high - 1] < x[high]], high[x[high + 1] != x[high]]
    next_end = np.searchsorted(ends, rises)
    rises, next_end = rises[next_end < len(ends)], next_end[next_end < len(ends)]  # a flat maximum may last to the end
    last = ends[next_end]
    falls = x[last + 1] < x[last]
    places = (rises[falls] + last[falls]) // 2
    return np.asarray(places[np.array(_highest(places, x[places], apart), bool)])


def _highest(places: IntArray, heights: FloatArray, apart: int) -> list[bool]:
    """Mark the ascending places to keep, at least `apart` from higher ones."""
    first = np.searchsorted(places, places - apart, side="right").tolist()
    behind = np.searchsorted(places, places + apart, side="left").tolist()
    kept = [True] * len(places)
    for i in np.argsort(heights)[::-1].tolist():
        if kept[i]:
            kept[first[i] : behind[i]] = [False] * (behind[i] - first[i])
            kept[i] = True
    return kept


def _reverberation_m(magnitude_m: FloatArray, rate_hz: float) -> FloatArray:
    """Return the height that normal reverberation exceeds once, (n,).

    In narrow-band noise a share ``exp(-u^2/(2 sigma^2))`` of the peaks is higher than u (Rice 1945). The standard
    deviation is estimated from the median magnitude, which short foci hardly change.
    """
    parts = np.array_split(magnitude_m, max(round(magnitude_m.size / (STEADY_S * rate_hz)), 1))
    sizes = np.array([part.size for part in parts])
    deviations_m = np.array([np.median(part) for part in parts]) / NORMAL_MEDIAN
    rising = np.diff(magnitude_m) > 0
    n_peaks = max(int(np.count_nonzero(rising[:-1] & np.logical_not(rising[1:]))), 1)
    course_m = np.interp(np.arange(magnitude_m.size), np.cumsum(sizes) - sizes / 2, deviations_m)
    return np.asarray(course_m * np.sqrt(2 * np.log(n_peaks)))


@checked
def felt_amplitude_m(times_s: Vector, peaks_m: Vector) -> float:
    """Return the single event (m) felt as strongly as a whole course.

    >>> felt_amplitude_m([0.01], [3e-6])
    3e-06
    """
    times, peaks = np.asarray(times_s, float), np.asarray(peaks_m, float)
    expect(len(times) == len(peaks), "peaks_m", len(peaks), f"{len(times)}, one per time")
    return summed_amplitude(times, peaks)


@lru_cache(maxsize=N_CACHED)
def _among(setup: Setup, places: Places, n_samples: int) -> ComplexArray:
    """Return receptances among places, (n_frequencies, n_places, n_places)."""
    return _receptances_of(setup, n_samples).among(values_at(setup.screen, list(places), setup.modes_to_hz))


@lru_cache(maxsize=N_CACHED)
def _free(setup: Setup, signal: Signal, places: Places) -> FloatArray:
    """Return the free plate during the drive, (n_places, n_samples)."""
    n = signal.samples.shape[1]
    if not places:
        return np.zeros((0, n))
    responses = impulse_responses(
        setup.screen, list(places), rate_hz=setup.rate_hz, duration_s=n / setup.rate_hz, f_max_hz=setup.modes_to_hz
    )
    return emitted(signal, responses)[:, :n]


@lru_cache(maxsize=N_CACHED)
def _between(setup: Setup, places: Places, n_samples: int) -> tuple[ComplexArray, ComplexArray]:
    """Return receptances from contacts to focus, and among the contacts."""
    receptances, at = _receptances(setup, n_samples), values_at(setup.screen, list(places), setup.modes_to_hz)
    at_focus = values_at(setup.screen, [setup.focus_m], setup.modes_to_hz)
    return receptances.between(at_focus, at), receptances.among(at)


@lru_cache(maxsize=2)
def _receptances(setup: Setup, n_samples: int) -> Receptances:
    return _receptances_of(setup, n_samples)


def _receptances_of(setup: Setup, n_samples: int) -> Receptances:
    s, _, _ = contour(n_samples, setup.rate_hz)
    return Receptances.of(setup.screen.oscillators(setup.modes_to_hz), setup.screen.plate.mass_kg, s)
