"""Foci at named places, and fingers that rest on these places."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from functools import lru_cache
from itertools import combinations
from math import dist
from typing import Final

import numpy as np

from tactometry.arguments.checked import Positive, checked
from tactometry.arguments.require import distinct, expect, lookup, of_kind

from ...defaults import FOCUS_AT_THRESHOLD_M
from ..finger import FINGER_DIAMETER_M
from ..responses.responses import Point, Responses
from .focus_train import FocusTrain
from .setup import Setup

AT_ONCE: Final = " + "
"""Separator between the names of places with simultaneous foci."""


@checked
@dataclass(frozen=True)
class Place:
    """A point of the plate; missing coordinates are those of the setup's focus.

    Parameters
    ----------
    x_m : float, optional
        Place along the length. Default: the setup's focus.
    y_m : float, optional
        Place along the width. Default: the setup's focus.
    """

    x_m: float | None = None
    y_m: float | None = None

    def on(self, setup: Setup) -> Point:
        """Return the coordinates (m) of the place on a setup's plate."""
        return setup.focus_x_m if self.x_m is None else self.x_m, setup.focus_y_m if self.y_m is None else self.y_m


@checked
@dataclass(frozen=True)
class PlacedFoci(FocusTrain):
    """A `FocusTrain` with foci at named places; the level is their mean amplitude.

    Simultaneous foci come from one drive, the sum of the reversed responses of their places. Each focus therefore also
    moves the other places (crosstalk).

    Raises `InvalidParameter` if a place is not on the plate, two places coincide, or `place` contains an unknown name.

    Parameters
    ----------
    places : mapping of str to Place
        At least two places, no two at the same point.
    place : str
        Place of the focus: a name, or several joined by `` + `` for simultaneous foci.
    setup, pattern, drive, f_min_hz, f_max_hz, reversal_s, voltage_max_v, duration_s, level_unit, repetition_hz
        As in `FocusTrain`.
    envelope, train_s, envelope_table, modulation, supply_v
        As in `FocusTrain`.

    >>> setup = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3)
    >>> places = {"index": Place(0.10), "middle": Place(0.13)}
    >>> both = PlacedFoci(setup, f_max_hz=20e3, places=places, place="index + middle")
    >>> both.places_made_m
    ((0.1, 0.093), (0.13, 0.093))
    >>> both.at(0.0).samples.shape
    (8, 350)
    """

    _: KW_ONLY
    places: dict[str, Place]
    place: str

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_places(self)
        for name in self._named:
            lookup("PlacedFoci.place", name, self.places)
        distinct("PlacedFoci.place", self._named, "each place once")

    def __hash__(self) -> int:
        return hash((self.setup, self.place, frozenset(self.places.items())))

    @property
    def _named(self) -> tuple[str, ...]:
        return tuple(name.strip() for name in self.place.split(AT_ONCE.strip()))

    @property
    def made(self) -> tuple[int, ...]:
        """Indices of the places that have a focus."""
        names = list(self.places)
        return tuple(names.index(name) for name in self._named)

    @property
    def places_made_m(self) -> tuple[Point, ...]:
        """The coordinates (m) of the places that have a focus."""
        everywhere = [place.on(self.setup) for place in self.places.values()]
        return tuple(everywhere[n] for n in self.made)

    def heard(self, learnt: Responses | None = None) -> Responses:
        """Return the mean response at the foci, learnt or of the model.

        Responses must be learnt at all places, in their order.

        Raises `InvalidParameter` if responses were learnt at a different number of places.
        """
        if learnt is None:
            return _mean_of_model(self.setup, self.places_made_m)
        expected = f"{len(self.places)}, one for each of {', '.join(self.places)}; learn them at these places"
        expect(learnt.n_points == len(self.places), "responses", f"{learnt.n_points} points", expected)
        return learnt.mean_of(self.made)


def _check_places(foci: PlacedFoci) -> None:
    expect(isinstance(foci.places, Mapping), "PlacedFoci.places", foci.places, "a table of places by their names")
    expect(len(foci.places) > 1, "PlacedFoci.places", f"{len(foci.places)} of them", "at least two")
    of_kind("PlacedFoci.places", Place, **foci.places)
    for name, place in foci.places.items():
        is_name = bool(name.strip()) and name.isprintable() and AT_ONCE.strip() not in name
        expect(is_name, "PlacedFoci.places", repr(name), f"a name on one line without {AT_ONCE.strip()!r}")
        foci.setup.plate.check_holds(f"PlacedFoci.places.{name}", place.on(foci.setup))
    for (name, place), (other, its) in combinations(foci.places.items(), 2):
        at_m = place.on(foci.setup)
        is_apart = at_m != its.on(foci.setup)
        expect(is_apart, f"PlacedFoci.places.{other}", f"the point of {name}, {at_m} m", "a different point")


@lru_cache(maxsize=16)
def _mean_of_model(setup: Setup, places: tuple[Point, ...]) -> Responses:
    each = [setup.responses_at(*at_m) for at_m in places]
    everywhere = Responses(np.concatenate([responses.samples for responses in each]), setup.rate_hz)
    return everywhere.mean_of(range(len(each)))


@checked
@dataclass(frozen=True)
class FingersSensation:
    """Settings of a scene of foci under fingers at named places.

    `tactometry.stimuli.scenes.default_scenes.default_scene` builds the scene.

    Each finger feels the field of all foci at its place, with the amplitude of the free plate. That fingers do not damp
    each other's motion is an unverified simplification, which the effect `finger_load` of a scene removes.

    Raises `InvalidParameter` if a finger is not on a place, or two fingers are closer than the width of a fingertip.

    Parameters
    ----------
    setup, places
        Screen and places of the stimulus.
    fingers : tuple of str
        Names of the places with a finger, at least `FINGER_DIAMETER_M` apart. Default: all places.
    reference_m : float
        Amplitude of a single focus at the detection threshold (the thesis: about 10 um).

    >>> FingersSensation(Setup(), {"index": Place(0.10), "middle": Place(0.13)}).reference_m
    1e-05
    """

    setup: Setup
    places: Mapping[str, Place]
    fingers: tuple[str, ...] = ()
    reference_m: Positive = FOCUS_AT_THRESHOLD_M

    def __post_init__(self) -> None:
        check_fingers("FingersSensation.fingers", self.setup, self.places, self.fingers)


@checked
def check_fingers(where: str, setup: Setup, places: Mapping[str, Place], fingers: tuple[str, ...]) -> None:
    """Raise an error for fingers without a place or less than a fingertip apart."""
    distinct(where, fingers, "each place once, as two fingers do not fit there")
    at_m = {name: lookup(where, name, places).on(setup) for name in fingers or places}
    for name, other in combinations(at_m, 2):
        apart_m = dist(at_m[name], at_m[other])
        wide = f"at least the {1e3 * FINGER_DIAMETER_M:g} mm of a fingertip; move a place or name fewer fingers"
        found = f"{name} and {other} {1e3 * apart_m:.3g} mm apart"
        expect(apart_m >= FINGER_DIAMETER_M * (1 - 1e-9), where, found, wide)
