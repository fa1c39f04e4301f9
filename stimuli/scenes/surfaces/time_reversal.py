"""A plate that focuses by time reversal: from a voltage to a focus, with whatever effects are called for."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import ceil, pi, sqrt
from typing import TYPE_CHECKING, Any, ClassVar

from tactometry import require
from tactometry.errors import InvalidParameter
from tactometry.stimuli.scenes.effect import Budget, Effect, Surroundings
from tactometry.stimuli.scenes.stage import Stage
from tactometry.stimuli.scenes.time_reversal.truncation import Cut, cut, n_frequencies, n_modes

if TYPE_CHECKING:
    from tactometry.stimuli.time_reversal.plate import Plate

EMISSION = "tactometry.stimuli.scenes.time_reversal.emission"
MOTION = "tactometry.stimuli.scenes.time_reversal.motion"
MAP = "tactometry.stimuli.scenes.time_reversal.map"
MOST_POINTS = 4e7
PRODUCT, DIVISION = 0.15, 15.0
"""Operations per number in a product of matrices, and where it is divided."""
MARGIN_FLANKS = 5.0
"""Margin around an emission, in periods of the flank: where what the flank rings is gone."""


@dataclass(frozen=True)
class TimeReversal:
    """A simply supported thin plate of glass without losses, pushed at points along its border by linear amplifiers.

    Every default is unverified. Displacements are those below `band_max_hz`, whatever a quantiser adds above.

    Parameters
    ----------
    glass : str
        A name of `tactometry.stimuli.time_reversal.glass.GLASSES`.
    length_m, width_m, thickness_m : float
    n_transducers : int
        Their centres `inset_m` from the edges.
    force_n_per_v : float
        Of each, as long as no effect makes it a patch.
    focus_x_m, focus_y_m : float
    band_max_hz, flank_hz : float
        Responses are learnt below the first, with a flank as wide as the second.
    rate_hz : float
        Clock of learning and emission.
    reversal_s, after_s : float
        Length of the emission, and for how long the plate is watched behind the focus.

    Raises
    ------
    InvalidParameter
        If a value is outside of its domain.

    >>> from tactometry.stimuli.scenes.scene import Scene
    >>> screen = TimeReversal(n_transducers=4, band_max_hz=10e3, flank_hz=1e3, rate_hz=50e3, reversal_s=2e-3)
    >>> peak_m = Scene(screen, (), ("peak_m",)).resolve().run({"voltage_v": 30.0})["peak_m"]
    >>> round(peak_m * 1e6, 2)
    0.51
    """

    kind: ClassVar[str] = "time_reversal"
    order: ClassVar[tuple[str, ...]] = (
        "edges", "shear", "attenuation", "patches", "foci", "drift", "amplifier", "filter", "quantiser",
        "repetition", "load", "movie", "sound", "energy", "detection",
    )  # fmt: skip
    effects: ClassVar[tuple[str, ...]] = (
        "edges", "shear", "attenuation", "patches", "foci", "temperature_drift", "amplifier", "audible_filter",
        "one_bit", "sigma_delta", "pulse_width", "repetition", "finger_load", "movie", "airborne_sound", "drive_energy",
        "focus_detection",
    )  # fmt: skip
    given: ClassVar[tuple[str, ...]] = ("voltage_v",)
    cures: ClassVar[Mapping[str, str]] = {
        "contact_force_n": "add the effect finger_load and a contact at rest",
        "contact_displacement_m": "add the effect finger_load and a contact at rest",
        "movie_m": "add the effect movie",
        "frames_s": "add the effect movie",
        "sound_level_dba": "add the effect airborne_sound",
        "energy_j": "add the effect drive_energy",
        "power_w": "add the effect drive_energy",
        "sensation_db": "add the effect focus_detection",
        "peaks_m": "add the effect foci",
    }

    glass: str = "Borofloat 33"
    length_m: float = 0.297
    width_m: float = 0.210
    thickness_m: float = 1.1e-3
    n_transducers: int = 32
    inset_m: float = 12e-3
    force_n_per_v: float = 1e-3
    focus_x_m: float = 0.121
    focus_y_m: float = 0.093
    band_max_hz: float = 60e3
    flank_hz: float = 6e3
    rate_hz: float = 250e3
    reversal_s: float = 7e-3
    after_s: float = 3e-3

    def __post_init__(self) -> None:
        require.positive("TimeReversal", **{k: v for k, v in vars(self).items() if k not in {"glass", "n_transducers"}})
        if self.n_transducers < 1:
            raise InvalidParameter(f"TimeReversal.n_transducers: found {self.n_transducers}, expected at least 1")
        _check_glass(self.glass)
        _check_place(self)
        _check_band(self)

    @property
    def plate(self) -> "Plate":
        """The plate as it is without effects."""
        from tactometry.stimuli.time_reversal.glass import GLASSES

        return GLASSES[self.glass].plate(self.length_m, self.width_m, self.thickness_m, "SSSS")

    @property
    def margin_s(self) -> float:
        """How far an emission is followed outside of itself when it is limited to the band."""
        return MARGIN_FLANKS / self.flank_hz

    def stages(self, scene: Surroundings, budget: Budget) -> tuple[Stage, ...]:
        found = cut(scene, budget.error)
        return (
            *self._emission(),
            *self._motion(scene, found),
            *self._courses(scene, found, budget),
            *self._map(scene, found, budget),
        )

    def stages_of(self, effect: Effect, scene: Surroundings, budget: Budget) -> tuple[Stage, ...]:
        """The stages of an effect, as it brings them."""
        return effect.stages(scene, budget)

    def _emission(self) -> tuple[Stage, ...]:
        learning = {name: getattr(self, name) for name in ("rate_hz", "reversal_s", "band_max_hz", "flank_hz")}
        plate = {name: getattr(self, name) for name in ("glass", "length_m", "width_m", "thickness_m")}
        pushes = {name: getattr(self, name) for name in ("n_transducers", "inset_m", "force_n_per_v")}
        band = {"band_max_hz": self.band_max_hz, "flank_hz": self.flank_hz, "margin_s": self.margin_s}
        n_samples = self.rate_hz * self.reversal_s * self.n_transducers
        learnt = 64 * self.plate.modal_density_s * self.band_max_hz * self.n_transducers + 100 * n_samples
        focus = {"x_m": self.focus_x_m, "y_m": self.focus_y_m}
        return (
            Stage("plate", (), "plate", f"{EMISSION}:glass_plate", plate),
            Stage("transducers", ("plate",), "sources", f"{EMISSION}:pushes", pushes),
            Stage("screen", ("plate", "sources"), "screen", f"{EMISSION}:lossless"),
            Stage("focus", (), "foci_m", f"{EMISSION}:single", focus),
            Stage("learning", ("screen", "foci_m"), "learnt", f"{EMISSION}:learning", learning, n_operations=learnt),
            Stage("amplifiers", (), "quantiser", f"{EMISSION}:analogue"),
            Stage("reversal", ("learnt", "quantiser"), "emission", f"{EMISSION}:quantised", n_operations=n_samples),
            Stage("band", ("emission",), "in_band", f"{EMISSION}:in_band", band, n_operations=200 * n_samples),
        )

    def _motion(self, scene: Surroundings, found: Cut) -> tuple[Stage, ...]:
        modes, n = n_modes(scene, found.modes_to_hz), n_frequencies(scene, found)
        settings = {
            "modes_to_hz": found.modes_to_hz,
            "static_to_hz": found.static_to_hz,
            "heard_to_hz": found.heard_to_hz,
            "after_s": self.after_s,
        }
        return (
            Stage(
                "motion",
                ("screen", "in_band"),
                "motion",
                f"{MOTION}:driven",
                settings,
                error=found.error,
                n_operations=modes * n * (PRODUCT * self.n_transducers + DIVISION),
            ),
            Stage(
                "instant", ("motion", "foci_m"), "per_volt_peaks", f"{MOTION}:focus_value", n_operations=4 * modes * n
            ),
            Stage("peak", ("per_volt_peaks", "voltage_v"), "peak_m", f"{__name__}:first_magnitude"),
        )

    def _courses(self, scene: Surroundings, found: Cut, budget: Budget) -> tuple[Stage, ...]:
        step_rad = 2 * pi * self.band_max_hz / self.rate_hz
        factor = ceil(step_rad / sqrt(8 * budget.error))
        n = n_frequencies(scene, found) * self.rate_hz / found.heard_to_hz * factor
        sampling = {"factor": factor}
        needs = ("motion", "foci_m", "oversampling")
        return (
            Stage("sampling", (), "oversampling", f"{MOTION}:sampling", sampling, error=(step_rad / factor) ** 2 / 8),
            Stage("times", ("motion", "oversampling"), "t_s", f"{MOTION}:course_times"),
            Stage("focus_course", needs, "per_volt_course", f"{MOTION}:focus_course", n_operations=100 * n),
            _times_voltage("focus_signal", "per_volt_course", "focus_displacement_m", n),
        )

    def _map(self, scene: Surroundings, found: Cut, budget: Budget) -> tuple[Stage, ...]:
        if {"field_m", "movie_m", "x_m", "y_m"}.isdisjoint(scene.outputs):
            return ()
        n_x, n_y = self.grid(scene, budget.error)
        still = n_modes(scene, found.static_to_hz)
        drawn = PRODUCT * 4 * sqrt(still) * n_x * n_y + 4.0 * still * self.n_transducers
        step_m = max(self.length_m / (n_x - 1), self.width_m / (n_y - 1))
        return (
            Stage("grid_x", ("plate",), "x_m", f"{MAP}:along_x", {"n": n_x}),
            Stage("grid_y", ("plate",), "y_m", f"{MAP}:along_y", {"n": n_y}),
            Stage(
                "field",
                ("motion", "x_m", "y_m"),
                "per_volt_field",
                f"{MAP}:focus_field",
                error=(self._wavenumber_rad_per_m(scene) * step_m) ** 2 / 8,
                n_operations=drawn,
            ),
            _times_voltage("field_at_focus", "per_volt_field", "field_m", n_x * n_y),
        )

    def grid(self, scene: Surroundings, error: float) -> tuple[int, int]:
        """Points along both sides, for an error of straight lines between them.

        Raises
        ------
        InvalidParameter
            If they are too many.
        """
        step_m = sqrt(8 * error) / self._wavenumber_rad_per_m(scene)
        n_x, n_y = ceil(self.length_m / step_m) + 1, ceil(self.width_m / step_m) + 1
        if n_x * n_y > MOST_POINTS:
            raise InvalidParameter(
                f"field_m: found an error of {error:.2g} left for a grid, which takes {n_x} x {n_y} points, expected "
                f"at most {MOST_POINTS:.2g} in all; loosen the accuracy or ask for focus_displacement_m"
            )
        return n_x, n_y

    def _wavenumber_rad_per_m(self, scene: Surroundings) -> float:
        """Of the shortest wave in the band."""
        shear: Any = scene.find("shear")
        if shear is not None:
            return float(shear.wavenumber_rad_per_m(self.plate, self.band_max_hz))
        return sqrt(2 * pi * self.band_max_hz / self.plate.wave_constant_m2_per_s)


def _times_voltage(name: str, per_volt: str, gives: str, n: float) -> Stage:
    return Stage(name, (per_volt, "voltage_v"), gives, f"{__name__}:multiplied", n_operations=float(n))


def first_magnitude() -> Callable[[Any, float], float]:
    """The magnitude of the first of some values, at a voltage."""
    return lambda values, voltage_v: float(abs(values[0] * voltage_v))


def multiplied() -> Callable[[Any, float], Any]:
    """Values per volt, at a voltage."""
    return lambda values, voltage_v: values * voltage_v


def _check_glass(glass: str) -> None:
    from tactometry.stimuli.time_reversal.glass import GLASSES

    require.one_of("TimeReversal.glass", glass, tuple(GLASSES))


def _check_place(surface: TimeReversal) -> None:
    if 2 * surface.inset_m >= min(surface.length_m, surface.width_m):
        raise InvalidParameter(
            f"TimeReversal.inset_m: found {surface.inset_m}, expected less than half of the shorter side, "
            f"{min(surface.length_m, surface.width_m) / 2} m"
        )
    for name, side in (("focus_x_m", "length_m"), ("focus_y_m", "width_m")):
        at_m, side_m = getattr(surface, name), getattr(surface, side)
        if not 0 < at_m < side_m:
            raise InvalidParameter(
                f"TimeReversal.{name}: found {at_m}, expected a place between the edges, 0 and {side_m} m"
            )


def _check_band(surface: TimeReversal) -> None:
    if 2 * surface.band_max_hz > surface.rate_hz:
        raise InvalidParameter(
            f"TimeReversal.band_max_hz: found {surface.band_max_hz}, expected at most half of rate_hz, "
            f"{surface.rate_hz / 2}; lower it or raise rate_hz"
        )
    if surface.flank_hz > surface.band_max_hz:
        raise InvalidParameter(
            f"TimeReversal.flank_hz: found {surface.flank_hz}, expected at most band_max_hz, {surface.band_max_hz}"
        )
