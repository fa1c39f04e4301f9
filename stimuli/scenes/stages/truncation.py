"""Number of modes for a tolerated error, from a-priori error estimates.

Modes above the band add a pulse at the arrival of each wave, while the response rings over the reversal time. The ratio
of their energies is ``2 / (pi w tau_e)`` with ``tau_e = tau (1 - e^{-2T/tau})/2``. Its root is the `remainder` of one
transducer. The focus is the sum of n transducers, so that 1/n of it counts.

Modes up to ``r`` times the band move, and modes up to ``q`` times the band follow with inertia to first order. The
error of the former falls as r^-5. The error of the latter is the static shape near a transducer, without the waves
shorter than those at q. A patch bends the plate by a step of curvature, ``1/k^3`` along its normal. The error is ``int
dk/k^3``, which is 1/q, at the outline, and ``int e^{ikd} dk/k^3``, which is q^-1.5 over ``k_band d``, at the distance
d. The error of a point force falls faster; a map contains an outline. Under a finger, which is a point force, modes
matter that no transducer moves.
"""

from dataclasses import dataclass
from math import exp, hypot, inf, pi, sqrt

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ...composition.content import PlateContent
from ...composition.effect import Demand, FingerContact, Surroundings

MOVING, STILL, TURNING = 2.0, 8.0, 2.0
"""Errors of the moving and of the following modes, as parts of one transducer's remainder, and the factor of
`Tail.turning`.

They are at least 1.7 times the worst of 340 random screens, most with the focus on or next to a transducer."""
OF_LOAD = 0.15
MOST_COUNTED = 32
"""Largest number of transducers counted as independent; further ones share their place with others."""
ROUNDING = 1e-9
HEARD = ((1e-3, 1.1), (0.0, 1.3))
"""Pairs of the least tolerated error and the highest frequency of an emission that counts, over the band."""
MOST_NUMBERS = 4.5e7
"""Limit of moving modes times frequencies: 34 bytes each at the measured peak of a run with fingers, 1.5 GB."""
MOST_FOLLOWING = 3e7
"""Limit of following modes times transducers."""
MOST_MODES = 9e5
MAPS = frozenset(("field_m", "movie_m"))


@dataclass(frozen=True)
class Cut:
    """Highest frequencies of the modes, and the truncation error."""

    modes_to_hz: float
    static_to_hz: float
    heard_to_hz: float
    error: float


@dataclass(frozen=True)
class Tail:
    """Truncation error at q times the band: `size` / q, faster past `turning`."""

    size: float
    turning: float

    def beyond(self, q: float) -> float:
        return self.size / q * min(1.0, self.turning / sqrt(q))

    def end(self, error: float) -> float:
        return min(self.size / error, float((self.size * self.turning / error) ** (2 / 3)))


def remainder(scene: Surroundings) -> float:
    """Return the root of the energy ratio above the band to in the band."""
    content = content_of(scene)
    tau_s = scene.surface.reversal_s
    if content.tau_s != inf:
        tau_s = float(content.tau_s * (1 - exp(-2 * tau_s / content.tau_s)) / 2)
    return content.weakening * sqrt(2 / (pi * 2 * pi * scene.surface.f_max_hz * tau_s))


def content_of(scene: Surroundings) -> PlateContent:
    """Return the sum of the content of all effects."""
    return sum((effect.in_plate(scene) for effect in scene.effects), start=PlateContent())


def cut_of(demand: Demand) -> Cut:
    """Return the cut for the error that a stage may add; see `cut`."""
    return cut(demand, demand.error)


def cut(scene: Surroundings, error: float) -> Cut:
    """Return the fewest modes for an error.

    Raises `InvalidParameter` if there are more than fit into one run.
    """
    surface, content = scene.surface, content_of(scene)
    # half for moving modes, half for following modes, and a little for the rounding of their sum
    half = error / (2 + ROUNDING)
    one = remainder(scene) / min(surface.n_transducers, MOST_COUNTED)
    moves = MOVING * one * content.reading + OF_LOAD * content.load
    ratio = max(1.0, (moves / half) ** (1 / 5))

    distance_m = _distance_m(scene)
    turning = TURNING / (wavenumber_rad_per_m(scene, surface.f_max_hz) * distance_m) if distance_m else inf
    places = Tail(STILL * one * content.reading, turning)
    tails = [places] if MAPS.isdisjoint(scene.outputs) else [places, Tail(STILL * one, inf)]
    follow = max(ratio, *(tail.end(half) for tail in tails))
    expected = moves / ratio**5 + max(tail.beyond(follow) for tail in tails)

    band_hz, audible = surface.f_max_hz, next(share for above, share in HEARD if error >= above)
    fewest = Cut(ratio * band_hz, follow * band_hz, audible * band_hz, expected)
    _check_size(scene, fewest, error)
    return fewest


def _distance_m(scene: Surroundings) -> float:
    """Return the least distance from a reading point to a transducer outline."""
    from ...time_reversal.screen.transducer import border

    surface, content = scene.surface, content_of(scene)
    reach_m = content.reach_m  # the outline is a square or a point
    centres = border(surface.plate, surface.n_transducers, surface.inset_m, surface.inset_m)
    return min(
        hypot(max(abs(x_m - centre.x_m) - reach_m, 0.0), max(abs(y_m - centre.y_m) - reach_m, 0.0))
        for centre in centres
        for x_m, y_m in ((surface.focus_x_m, surface.focus_y_m), *content.places_m)
    )


def n_modes(scene: Surroundings, frequency_hz: float) -> float:
    """Return the approximate number of modes below a frequency."""
    return float(scene.surface.plate.area_m2 * wavenumber_rad_per_m(scene, frequency_hz) ** 2 / (4 * pi))


def wavenumber_rad_per_m(scene: Surroundings, frequency_hz: float) -> float:
    """Return the wavenumber of a thin plate, unless an effect changes it."""
    plate = scene.surface.plate
    changed = (effect.wavenumber_rad_per_m(plate, frequency_hz) for effect in scene.effects)
    thin = sqrt(2 * pi * frequency_hz / plate.wave_constant_m2_per_s)
    return next((wavenumber for wavenumber in changed if wavenumber is not None), thin)


def n_frequencies(scene: Surroundings, ends: Cut) -> int:
    """Return the number of complex frequencies of a run."""
    surface = scene.surface
    watched_s = surface.reversal_s + content_of(scene).train_s + surface.after_s + 2 * surface.margin_s
    return int(2.1 * ends.heard_to_hz * watched_s)


def n_frequencies_of_sound(scene: Surroundings) -> float:
    """Return the number of frequencies of `noise`."""
    surface, content = scene.surface, content_of(scene)
    return float(surface.rate_hz * (surface.reversal_s + content.train_s + content.ringing_s))


def _check_size(scene: Surroundings, ends: Cut, error: float) -> None:
    moving = n_modes(scene, ends.modes_to_hz) * n_frequencies(scene, ends)
    n_static = n_modes(scene, ends.static_to_hz)
    following = n_static * scene.surface.n_transducers
    sizes = (moving, MOST_NUMBERS), (following, MOST_FOLLOWING), (n_static, MOST_MODES)
    numbers, most = max(sizes, key=lambda size: size[0] / size[1])
    found = f"an error budget of {error:.2g} for the modes, which takes {numbers:.2g} numbers"
    expected = f"at most {most:.2g}; loosen the accuracy, lower f_max_hz or reversal_s, or use a thicker plate"
    expect(numbers <= most, "accuracy", found, expected)
    for effect in scene.effects:
        most = effect.in_plate(scene).most_ritz_modes
        if n_static > most:
            raise InvalidParameter(
                f"accuracy: found an error budget of {error:.2g} for the modes, {n_static:.0f} modes of a plate "
                f"whose edges are not simply supported, expected at most {most:.0f}; loosen the accuracy, lower "
                f"f_max_hz, or remove {effect.kind!r}"
            )


Place = tuple[float, float]


def at_rest(scene: Surroundings) -> list[FingerContact]:
    """Return the contacts at rest."""
    return [touch for touch in scene.contacts if not touch.slides]


def places_m(scene: Surroundings) -> list[Place]:
    """Return the places of resting fingers; by default the focus."""
    x_m, y_m = scene.surface.focus_m
    return [(x_m if at.x_m is None else at.x_m, y_m if at.y_m is None else at.y_m) for at in at_rest(scene)]


def check_on_plate(scene: Surroundings) -> None:
    """Raise an error if a resting finger is outside the plate."""
    plate = scene.surface.plate
    for n, (x_m, y_m) in enumerate(places_m(scene)):
        expected = f"a place on the plate of {plate.length_m} x {plate.width_m} m"
        expect(plate.contains(x_m, y_m), f"contacts[{n}]", f"({x_m}, {y_m}) m", expected)


def felt_at_m(scene: Surroundings) -> Place:
    """Return the place of the first resting finger; by default the focus."""
    focus_m: Place = scene.surface.focus_m
    return next(iter(places_m(scene)), focus_m)


def is_away(scene: Surroundings) -> bool:
    """Return True if the first resting finger is away from the focus."""
    focus_m: Place = scene.surface.focus_m
    return felt_at_m(scene) != focus_m


def farther(scene: Surroundings) -> float:
    """Return the approximate ratio of the focus to the motion elsewhere."""
    surface = scene.surface
    return float((surface.plate.modal_density_s * surface.f_max_hz) ** 0.5)
