"""What a vibrometer reads at the focus while something presses on the plate: there, or elsewhere."""

from dataclasses import dataclass, field
from functools import lru_cache
from math import inf
from typing import Final, Literal

import numpy as np

from tactometry.arguments.checked import checked
from tactometry.contact import Contact
from tactometry.signal import Signal

from ...arrays import ComplexArray, FloatArray
from ..finger import FINGER_DIAMETER_M, Contactor
from ..focusing.focusing import emitted
from ..responses.load import PlateLoad, Receptances, carried, contour
from ..responses.responses import impulse_responses, values_at
from .sensation import Keyed
from .setup import Setup

Places = tuple[tuple[float, float], ...]

N_CACHED: Final = 32
READING_M: Final = 1e-9
"""One nanometre, the unit of a reading."""


@checked
@dataclass(frozen=True)
class FocusReading:
    """The largest displacement at the focus, in dB re 1 nm, with a contactor on the plate: `sensation_db` for a rig.

    Parameters
    ----------
    setup : Setup
        The screen and focus, the same as the stimulus has.
    contactor : {"finger", "soft", "rigid"}
        As in `Contactor`, whose constants are unverified defaults.
    diameter_m : float
        Of a soft or rigid contactor, above 0.
    x_m, y_m : float, optional
        Where it presses; by default at the focus.

    Examples
    --------
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
    def place_m(self) -> tuple[float, float]:
        x_m, y_m = self.setup.focus_m
        return (x_m if self.x_m is None else self.x_m, y_m if self.y_m is None else self.y_m)

    def sensation_db(self, signal: Signal, contact: Contact) -> float:
        """The reading in dB re 1 nm; ``-inf`` for none."""
        loads = Contactor(self.contactor, self.diameter_m).loads(self.setup.screen.plate, self.place_m, contact.force_n)
        amplitude_m = float(np.abs(displacement_at_focus_m(self.setup, signal, loads)).max(initial=0.0))
        return -inf if amplitude_m == 0 else float(20 * np.log10(amplitude_m / READING_M))


@checked
def displacement_at_focus_m(setup: Setup, signal: Signal, loads: list[PlateLoad]) -> FloatArray:
    """(n_samples,): the focus point while the drive lasts, loads on the plate: U_f - T U_c, T = H_fc Z (1 + H_cc Z)^-1.

    U_f and U_c are the free plate's displacements at the focus and at the contacts; solved on the contour of
    `load.contour`, as in `load.loaded_responses`.
    """
    n = signal.samples.shape[1]
    places = tuple((load.x_m, load.y_m) for load in loads)
    free_m, at_contacts = _free(setup, Keyed(signal), (setup.focus_m,)), _free(setup, Keyed(signal), places)
    if all(load == PlateLoad(load.x_m, load.y_m) for load in loads):
        return np.asarray(free_m[0])
    s, growth, n_fft = contour(n, setup.rate_hz)
    stiffness = np.stack([load.dynamic_stiffness(s) for load in loads], axis=1)
    toward = carried(*_between(setup, places, n), stiffness)[0]
    taken = np.einsum("kf,kf->f", toward, np.fft.rfft(at_contacts / growth, n_fft))
    return np.asarray(free_m[0] - np.fft.irfft(taken, n_fft)[:n] * growth)


@lru_cache(maxsize=N_CACHED)
def _free(setup: Setup, keyed: Keyed, places: Places) -> FloatArray:
    """(n_places, n_samples): the free plate while the drive lasts."""
    n = keyed.signal.samples.shape[1]
    if not places:
        return np.zeros((0, n))
    heard = impulse_responses(
        setup.screen, list(places), rate_hz=setup.rate_hz, duration_s=n / setup.rate_hz, f_max_hz=setup.modes_to_hz
    )
    return emitted(keyed.signal, heard)[:, :n]


@lru_cache(maxsize=N_CACHED)
def _between(setup: Setup, places: Places, n_samples: int) -> tuple[ComplexArray, ComplexArray]:
    """Receptances from the contacts to the focus, and among the contacts."""
    receptances, at = _receptances(setup, n_samples), values_at(setup.screen, list(places), setup.modes_to_hz)
    at_focus = values_at(setup.screen, [setup.focus_m], setup.modes_to_hz)
    return receptances.between(at_focus, at), receptances.among(at)


@lru_cache(maxsize=2)
def _receptances(setup: Setup, n_samples: int) -> Receptances:
    s, _, _ = contour(n_samples, setup.rate_hz)
    screen = setup.screen
    return Receptances.of(screen.oscillators(setup.modes_to_hz), screen.plate.mass_kg, s)
