"""Where fingers are on a plate that focuses."""

from tactometry.errors import InvalidParameter

from ...composition.effect import FingerContact, Surroundings

Place = tuple[float, float]


def at_rest(scene: Surroundings) -> list[FingerContact]:
    """The contacts that rest."""
    return [touch for touch in scene.contacts if not touch.slides]


def places_m(scene: Surroundings) -> list[Place]:
    """Where they rest: without a place of their own, at the focus."""
    return [_place(touch, scene.surface.focus_m) for touch in at_rest(scene)]


def check_on_plate(scene: Surroundings) -> None:
    """Refuse a finger that rests beside the plate.

    Raises
    ------
    InvalidParameter
        At the first.
    """
    plate = scene.surface.plate
    for n, (x_m, y_m) in enumerate(places_m(scene)):
        if not plate.contains(x_m, y_m):
            raise InvalidParameter(
                f"contacts[{n}]: found ({x_m}, {y_m}) m, expected a place on the plate of "
                f"{plate.length_m} x {plate.width_m} m"
            )


def felt_at_m(scene: Surroundings) -> Place:
    """Where the first of them feels; without any, at the focus."""
    focus_m: Place = scene.surface.focus_m
    return next(iter(places_m(scene)), focus_m)


def is_away(scene: Surroundings) -> bool:
    """Whether that is beside the focus."""
    focus_m: Place = scene.surface.focus_m
    return felt_at_m(scene) != focus_m


def farther(scene: Surroundings) -> float:
    """How much larger the focus is than what the plate does elsewhere, about."""
    surface = scene.surface
    return float((surface.plate.modal_density_s * surface.f_max_hz) ** 0.5)


def _place(touch: FingerContact, focus_m: Place) -> Place:
    at_x_m, at_y_m = focus_m
    return at_x_m if touch.x_m is None else touch.x_m, at_y_m if touch.y_m is None else touch.y_m
