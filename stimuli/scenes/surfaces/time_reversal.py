"""Plates that focus by time reversal."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from math import ceil, pi, sqrt
from typing import TYPE_CHECKING, Any, ClassVar, Final

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from ...composition.effect import Demand, Size, Stage, Surface, Surroundings
from ...defaults import F_MAX_HZ
from ...time_reversal.plate.glass import GLASSES
from ...time_reversal.plate.plate import Plate
from ...time_reversal.screen.glass_panel import LEARNT_S, GlassPanel
from ..effects import OF_TIME_REVERSAL
from ..stages.circuit import at_voltage
from ..stages.truncation import check_on_plate, cut_of, felt_at_m, n_frequencies, n_modes, wavenumber_rad_per_m
from . import REFUSES

if TYPE_CHECKING:
    from .played_plates import PlayedTimeReversal

OF_EVERY_STIMULUS: Final = {"tau_s", "side_m"}
"""Fields of a `Setup` that only effects set on this plate, but that every stimulus has by default."""
EMISSION = "tactometry.stimuli.scenes.stages.emission"
MOTION = "tactometry.stimuli.scenes.stages.motion"
MOST_POINTS = 4e7
PRODUCT, DIVISION = 0.15, 15.0
"""Operations per number in a matrix product, alone and with division."""
MARGIN_FLANKS = 5.0
"""Margin around an emission, in periods of the flank, after which the ringing of the flank has decayed."""


@dataclass(frozen=True)
class TimeReversal(GlassPanel, Surface):
    """A lossless, simply supported thin glass plate, driven at points along its border by linear amplifiers.

    Every default is unverified. Displacements only include frequencies below `f_max_hz`.

    Parameters
    ----------
    glass : str
        A name of `tactometry.stimuli.time_reversal.plate.glass.GLASSES`.
    length_m : float
        Length of the plate (x).
    width_m : float
        Width of the plate (y).
    thickness_m : float
        Thickness of the plate.
    n_transducers : int
        Number of transducers, with centres `inset_m` from the edges.
    force_n_per_v : float
        Force of each transducer, unless an effect makes it a patch.
    focus_x_m : float
        Place of the focus along the length.
    focus_y_m : float
        Place of the focus along the width.
    f_max_hz : float
        Frequency below which responses are learnt.
    flank_hz : float
        Width of the band over which the responses fall to nothing above `f_max_hz`.
    rate_hz : float
        Clock of learning and emission.
    reversal_s : float
        Duration of the emission.
    after_s : float
        Time for which the plate is observed after the focus.
    inset_m : float
        Distance of the transducers' centres from the edges.

    >>> from tactometry.stimuli.scenes.scene import Scene
    >>> screen = TimeReversal(n_transducers=4, f_max_hz=10e3, flank_hz=1e3, rate_hz=50e3, reversal_s=2e-3)
    >>> peak_m = Scene(screen, (), ("peak_m",)).resolve().run({"voltage_v": 30.0})["peak_m"]
    >>> round(peak_m * 1e6, 2)
    0.51
    """

    kind = "time_reversal"
    effects = OF_TIME_REVERSAL
    refuses = REFUSES
    given = ("voltage_v",)
    assumes: ClassVar[Mapping[str, str]] = {
        "edges": "edges simply supported all around",
        "shear": "a thin plate, without shear and rotary inertia",
        "attenuation": "a plate without losses",
        "patches": "transducers that are point forces without mass",
        "drift": "the temperature of learning",
        "amplifier": "amplifiers without a roll-off",
        "deflection": "a plate that moves by much less than its thickness",
    }

    force_n_per_v: float = 1e-3
    f_max_hz: float = F_MAX_HZ
    flank_hz: float = 6e3
    reversal_s: float = LEARNT_S
    after_s: float = 3e-3

    def __post_init__(self) -> None:
        require.positive("TimeReversal", **{k: v for k, v in vars(self).items() if k not in {"glass", "n_transducers"}})
        self._check_panel(highest_hz="f_max_hz")
        found, expected = self.inset_m, f"less than half of the shorter side, {min(self.length_m, self.width_m) / 2} m"
        require.expect(2 * self.inset_m < min(self.length_m, self.width_m), "TimeReversal.inset_m", found, expected)
        for name, side in (("focus_x_m", "length_m"), ("focus_y_m", "width_m")):
            at_m, side_m = getattr(self, name), getattr(self, side)
            require.expect(
                0 < at_m < side_m, f"TimeReversal.{name}", at_m, f"a place between the edges, 0 and {side_m} m"
            )
        if self.flank_hz > self.f_max_hz:
            raise InvalidParameter(
                f"TimeReversal.flank_hz: found {self.flank_hz}, expected at most f_max_hz, {self.f_max_hz}"
            )
        if round(self.reversal_s * self.rate_hz) < 1:
            raise InvalidParameter(
                f"TimeReversal.reversal_s: found {self.reversal_s}, expected at least one sample of rate_hz, "
                f"{1 / self.rate_hz} s; raise it or rate_hz"
            )

    @property
    def plate(self) -> Plate:
        """The plate without effects."""
        return GLASSES[self.glass].plate(self.length_m, self.width_m, self.thickness_m, "SSSS")

    @property
    def margin_s(self) -> float:
        """Time that the band limit adds before and after an emission."""
        return MARGIN_FLANKS / self.flank_hz

    def stages(self, scene: Demand) -> tuple[Stage, ...]:
        for n, touch in enumerate(scene.contacts):
            if touch.slides:
                raise InvalidParameter(
                    f"contacts[{n}]: found a finger that slides ({touch.speed_m_per_s} m/s) on a plate that focuses, "
                    "expected one at rest; remove speed_m_per_s, or use the surface 'hybrid'"
                )
        return (*self._emission(), *self._motion(scene), *self._map())

    def played(self, scene: Surroundings) -> "PlayedTimeReversal":
        """Return the plate of a stimulus, with the effects that define it."""
        from ...time_reversal.stimulus.setup import Setup
        from .played_plates import PlayedTimeReversal

        made = {name: value for effect in scene.effects for name, value in effect.in_setup().items()}
        stated = set(made) >= OF_EVERY_STIMULUS
        lacking = "a plate without losses or patches for a played signal"
        require.expect(stated, "effects", lacking, "both, as in a stimulus; add 'attenuation' and 'patches'")
        panel = {field.name: getattr(self, field.name) for field in fields(GlassPanel)}
        modes_to_hz = min(self.f_max_hz + self.flank_hz, self.rate_hz / 2)
        setup = Setup(**panel, **made, modes_to_hz=modes_to_hz, learnt_s=self.reversal_s)
        places = [(touch.x_m, touch.y_m) for touch in scene.contacts if not touch.slides]
        return PlayedTimeReversal(setup, *(places[0] if places else ()))

    def _emission(self) -> tuple[Stage, ...]:
        learning = {name: getattr(self, name) for name in ("rate_hz", "reversal_s", "f_max_hz", "flank_hz")}
        plate = {name: getattr(self, name) for name in ("glass", "length_m", "width_m", "thickness_m")}
        pushes = {name: getattr(self, name) for name in ("n_transducers", "inset_m", "force_n_per_v")}
        band = {"f_max_hz": self.f_max_hz, "flank_hz": self.flank_hz, "margin_s": self.margin_s}
        n_samples = self.rate_hz * self.reversal_s * self.n_transducers
        learnt = 64 * self.plate.modal_density_s * self.f_max_hz * self.n_transducers + 100 * n_samples
        focus = {"x_m": self.focus_x_m, "y_m": self.focus_y_m}
        return (
            Stage("plate", (), "plate", f"{EMISSION}:glass_plate", plate),
            Stage("transducers", ("plate",), "sources", f"{EMISSION}:pushes", pushes),
            Stage("screen", ("plate", "sources"), "screen", f"{EMISSION}:lossless"),
            Stage("focus", (), "foci_m", f"{EMISSION}:single", focus),
            Stage("learning", ("screen", "foci_m"), "learnt", f"{EMISSION}:learning", learning, n_operations=learnt),
            Stage("amplifiers", (), "quantiser", f"{EMISSION}:analogue"),
            Stage("reversal", ("learnt", "quantiser"), "emission", f"{EMISSION}:emit", n_operations=n_samples),
            Stage("band", ("emission",), "in_band", f"{EMISSION}:in_band", band, n_operations=200 * n_samples),
        )

    def _motion(self, scene: Demand) -> tuple[Stage, ...]:
        needs, in_course = ("motion", "foci_m", "oversampling"), ("motion", "oversampling")
        finger_m = dict(zip(("x_m", "y_m"), felt_at_m(scene), strict=True))
        at_finger, courses = f"{MOTION}:course_at", f"{MOTION}:focus_course"
        return (
            Stage("motion", ("screen", "in_band"), "motion", f"{MOTION}:plate_motion", size=self._motion_size),
            Stage("instant", needs[:2], "per_volt_peaks", f"{MOTION}:focus_value", size=_instant_size),
            Stage("peak", ("per_volt_peaks", "voltage_v"), "peak_m", f"{__name__}:first_magnitude"),
            Stage("sampling", (), "oversampling", f"{MOTION}:sampling", size=self._sampling_size),
            Stage("times", in_course, "t_s", f"{MOTION}:PlateMotion.times_s"),
            Stage("focus_course", needs, "per_volt_course", courses, size=_per_sample(100.0)),
            Stage("finger_course", in_course, "per_volt_finger", at_finger, finger_m, size=_under_finger),
            at_voltage("focus_signal", "per_volt_course", "focus_displacement_m", _per_sample(1.0)),
        )

    def _motion_size(self, demand: Demand) -> Size:
        ends = vars(demand.once(cut_of)) | {"after_s": self.after_s}
        error = ends.pop("error")
        work = demand.once(_n_moved) * (PRODUCT * self.n_transducers + DIVISION)
        return Size(ends, error, work)

    def _sampling_size(self, demand: Demand) -> Size:
        factor = demand.once(_oversampling)
        return Size({"factor": factor}, (self.step_rad / factor) ** 2 / 8)

    @property
    def step_rad(self) -> float:
        """Phase (rad) per sample at the top of the band."""
        return 2 * pi * self.f_max_hz / self.rate_hz

    def _map(self) -> tuple[Stage, ...]:
        needs = ("motion", "x_m", "y_m")
        return (
            Stage("grid_x", (), "x_m", f"{MOTION}:along", {"side_m": self.length_m}, size=self._along(0)),
            Stage("grid_y", (), "y_m", f"{MOTION}:along", {"side_m": self.width_m}, size=self._along(1)),
            Stage("field", needs, "per_volt_field", f"{MOTION}:focus_field", size=self._field_size),
            at_voltage("field_at_focus", "per_volt_field", "field_m", self._per_point),
        )

    def _along(self, axis: int) -> Callable[[Demand], Size]:
        return lambda demand: Size({"n": demand.once(self.grid)[axis]})

    def _per_point(self, demand: Demand) -> Size:
        n_x, n_y = demand.once(self.grid)
        return Size(n_operations=float(n_x * n_y))

    def _field_size(self, demand: Demand) -> Size:
        n_x, n_y = demand.once(self.grid)
        still = n_modes(demand, demand.once(cut_of).static_to_hz)
        drawn = PRODUCT * 4 * sqrt(still) * n_x * n_y + 4.0 * still * self.n_transducers
        return Size(error=self.grid_error(demand), n_operations=drawn)

    def grid(self, demand: Demand) -> tuple[int, int]:
        """Return the grid points along both sides for an interpolation error.

        Raises `InvalidParameter` if there are too many.
        """
        step_m = sqrt(8 * demand.error) / wavenumber_rad_per_m(demand, self.f_max_hz)
        n_x, n_y = ceil(self.length_m / step_m) + 1, ceil(self.width_m / step_m) + 1
        found = f"an error budget of {demand.error:.2g} for a grid, which takes {n_x} x {n_y} points"
        expected = f"at most {MOST_POINTS:.2g} in all; loosen the accuracy or request focus_displacement_m"
        require.expect(n_x * n_y <= MOST_POINTS, "field_m", found, expected)
        return n_x, n_y

    def grid_error(self, demand: Demand) -> float:
        """Return the interpolation error over the largest value of a map."""
        n_x, n_y = demand.once(self.grid)
        step_m = max(self.length_m / (n_x - 1), self.width_m / (n_y - 1))
        return (wavenumber_rad_per_m(demand, self.f_max_hz) * step_m) ** 2 / 8


def _n_moved(demand: Demand) -> float:
    """Return the number of moving modes times frequencies."""
    ends = demand.once(cut_of)
    return n_modes(demand, ends.modes_to_hz) * n_frequencies(demand, ends)


def _oversampling(demand: Demand) -> int:
    """Return the oversampling that linear interpolation needs."""
    step_rad: float = demand.surface.step_rad
    return ceil(step_rad / sqrt(8 * demand.error))


def _instant_size(demand: Demand) -> Size:
    return Size(n_operations=4.0 * demand.once(_n_moved))


def _per_sample(n_operations: float) -> Callable[[Demand], Size]:
    def size(demand: Demand) -> Size:
        ends, factor = demand.once(cut_of), demand.once(_oversampling)
        n = n_frequencies(demand, ends) * demand.surface.rate_hz / ends.heard_to_hz * factor
        return Size(n_operations=n_operations * n)

    return size


def _under_finger(demand: Demand) -> Size:
    """Return the per-volt course under a finger. Raises if it is off the plate."""
    check_on_plate(demand)
    return _per_sample(100.0)(demand)


def first_magnitude(values: Any, voltage_v: float) -> float:
    """Return the magnitude of the first value at a voltage."""
    return float(abs(values[0] * voltage_v))
