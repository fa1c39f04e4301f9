"""How many modes a reading needs: a-priori errors, fitted to random scenes with a margin, kept by tests.

What modes above the band do is a pulse at the arrival of each wave, against a response that rings over the reversal:
an energy ratio of ``2 / (pi w tau_e)``, ``tau_e = tau (1 - e^{-2T/tau})/2``. Its root is the `remainder`. The modes
up to ``r`` times the band move, those up to ``q`` times the band follow with inertia to first order: what is lost
falls with the fifth power of r and the square of q. A map is asked at its worst place, the edge of a patch, where it
falls with q, and against the focus of all transducers; a single point is far from it. Under a finger, a force at a
point, the modes matter that no transducer moves.
"""

from dataclasses import dataclass
from math import exp, inf, pi, sqrt
from typing import Any

from tactometry.errors import InvalidParameter
from tactometry.stimuli.scenes.effect import Surroundings

MOVING, MOVING_ON_MAP, STILL, STILL_ON_MAP = 0.04, 0.08, 0.3, 2.5
"""Parts of the remainder, of the modes that move and of those that follow; the last of one transducer."""
OF_LOAD = 0.15
FEW_TRANSDUCERS = 16
"""Fewer of them make a weaker focus beside what each does at its own place: more of the remainder counts."""
ROUNDING = 1e-9
HEARD = ((1e-3, 1.1), (0.0, 1.3))
"""How far above its band an emission is followed, by the error from which on that is enough."""
MOST_NUMBERS = 3e7
MOST_RITZ_MODES = 4000
MOST_MODES = 9e5
MAPS = frozenset(("field_m", "movie_m"))


@dataclass(frozen=True)
class Cut:
    """Where the modes end, and the error of that."""

    modes_to_hz: float
    static_to_hz: float
    heard_to_hz: float
    error: float


def remainder(scene: Surroundings) -> float:
    """Root of the energy of the modes above the band over that of a response in it, at the focus."""
    surface: Any = scene.surface
    tau_s = _effective_tau_s(scene)
    return _weakening(scene) * sqrt(2 / (pi * 2 * pi * surface.band_max_hz * tau_s))


def cut(scene: Surroundings, error: float) -> Cut:
    """The fewest modes for an error.

    Raises
    ------
    InvalidParameter
        If they are more than one run can hold.
    """
    surface: Any = scene.surface
    left, load = remainder(scene), _load(scene)
    on_map = not MAPS.isdisjoint(scene.outputs)
    half = error / (2 + ROUNDING)
    few = max(1.0, FEW_TRANSDUCERS / surface.n_transducers)
    moves = (MOVING_ON_MAP if on_map else MOVING * few) * left + load
    ratio = max(1.0, (moves / half) ** (1 / 5))
    still, power = (STILL_ON_MAP / surface.n_transducers, 1) if on_map else (STILL * few**3, 2)
    follow = max(ratio, (still * left / half) ** (1 / power))
    expected = moves / ratio**5 + still * left / follow**power
    band_hz = surface.band_max_hz
    found = Cut(ratio * band_hz, follow * band_hz, _heard(error) * band_hz, expected)
    _check_size(scene, found, error)
    return found


def _heard(error: float) -> float:
    return next(share for above, share in HEARD if error >= above)


def n_modes(scene: Surroundings, frequency_hz: float) -> float:
    """About how many modes there are below a frequency."""
    surface: Any = scene.surface
    shear: Any = scene.find("shear")
    if shear is None:
        return float(surface.plate.modal_density_s * frequency_hz)
    return float(surface.plate.area_m2 * shear.wavenumber_rad_per_m(surface.plate, frequency_hz) ** 2 / (4 * pi))


def n_frequencies(scene: Surroundings, found: Cut) -> int:
    """Complex frequencies of a run."""
    surface: Any = scene.surface
    watched_s = surface.reversal_s + _train_s(scene) + surface.after_s + 2 * surface.margin_s
    return int(2.1 * found.heard_to_hz * watched_s)


def n_frequencies_of_sound(scene: Surroundings) -> float:
    """Frequencies that `tactometry.stimuli.time_reversal.sound.noise` takes."""
    surface, attenuation = _of(scene)
    return float(surface.rate_hz * (surface.reversal_s + _train_s(scene) + 3 * attenuation.tau_s))


def _of(scene: Surroundings) -> tuple[Any, Any]:
    return scene.surface, scene.find("attenuation")


def _train_s(scene: Surroundings) -> float:
    repetition: Any = scene.find("repetition")
    return 0.0 if repetition is None else float(repetition.duration_s)


def _check_size(scene: Surroundings, found: Cut, error: float) -> None:
    moving = n_modes(scene, found.modes_to_hz) * n_frequencies(scene, found)
    following = n_modes(scene, found.static_to_hz) * scene.surface.n_transducers  # type: ignore[attr-defined]
    numbers = max(moving, following, n_modes(scene, found.static_to_hz) * MOST_NUMBERS / MOST_MODES)
    if numbers > MOST_NUMBERS:
        raise InvalidParameter(
            f"scene.accuracy: found an error of {error:.2g} left for the modes, which takes {numbers:.2g} numbers, "
            f"expected at most {MOST_NUMBERS:.2g}; loosen the accuracy, lower band_max_hz or reversal_s, or use a "
            "thicker plate"
        )
    ritz = n_modes(scene, found.static_to_hz)
    if scene.find("edges") is not None and ritz > MOST_RITZ_MODES:
        raise InvalidParameter(
            f"scene.accuracy: found an error of {error:.2g} left for the modes, which takes {ritz:.0f} of a plate "
            f"whose edges are not simply supported, expected at most {MOST_RITZ_MODES}; loosen the accuracy, lower "
            "band_max_hz, or remove 'edges'"
        )


def _effective_tau_s(scene: Surroundings) -> float:
    """How long a response lasts within the reversal time, at the top of the band."""
    surface, attenuation = _of(scene)
    tau_s = inf if attenuation is None else attenuation.tau_at_s(surface.band_max_hz)
    if tau_s == inf:
        return float(surface.reversal_s)
    return float(tau_s * (1 - exp(-2 * surface.reversal_s / tau_s)) / 2)


def _load(scene: Surroundings) -> float:
    """The share that the finger's own spot adds."""
    load: Any = scene.find("load")
    return 0.0 if load is None else float(OF_LOAD * load.impedance_ratio(scene))


def _weakening(scene: Surroundings) -> float:
    """How much smaller than the plainest focus the reading is that errors are relative to."""
    effects: list[Any] = [scene.find(slot) for slot in ("drift", "foci", "filter", "repetition", "load")]
    factor = 1.0
    for effect in effects:
        if effect is not None:
            factor *= effect.weakening(scene)
    return factor
