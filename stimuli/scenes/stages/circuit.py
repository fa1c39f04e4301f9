"""Stages that several surfaces and effects share."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from tactometry.arguments.require import expect

from ...composition.effect import Demand, Size, Stage
from ...composition.sampling import per_sample

if TYPE_CHECKING:
    from ...arrays import FloatArray
    from ...electrovibration.attraction.force import ForceForm
    from ...electrovibration.waveforms.pieces import Pieces

MULTIPLY = "operator:mul"
HIGHEST = f"{__name__}:highest"
RECORD = "tactometry.stimuli.scenes.stages.record"
NEEDS = ("t_s", "unit_voltage", "form")


def divider_stage() -> Stage:
    """Return the stage for the voltage across a layer without losses."""
    return Stage("divider", NEEDS, "unit_layer_voltage_v", f"{__name__}:divider", size=per_sample(700.0))


def circuit_stage(effect: str) -> Stage:
    """Return the stage that solves the circuit with losses for an effect."""

    def size(demand: Demand) -> Size:
        check_ramp(demand, effect)
        return per_sample(1500.0)(demand)

    return Stage("circuit", NEEDS, "unit_layer_voltage_v", f"{__name__}:relaxation", size=size)


def of_true_area() -> Stage:
    """Return the stage of the force law at the true contact area."""
    return Stage("true_area", ("area_m2",), "form_area_m2", f"{__name__}:same")


def same(area_m2: float) -> float:
    """Return the area."""
    return area_m2


def check_ramp(demand: Demand, effect: str) -> None:
    """Raise an error if a tone has no ramp."""
    expected = "a ramp; set ramp_s of the tone above 0"
    expect(demand.surface.ramp_s, effect, "a tone without a ramp (ramp_s = 0)", expected)


def divider(t_s: "FloatArray", voltage: "Pieces", form: "ForceForm") -> "FloatArray":
    """Return the voltage (n,) across a layer without losses."""
    gain = sum(form.relaxations.gains, start=form.relaxations.dc_gain)
    return gain * voltage.at(t_s)


def relaxation(t_s: "FloatArray", voltage: "Pieces", form: "ForceForm") -> "FloatArray":
    """Return the exact voltage (n,) across a layer of a circuit with losses."""
    from ...electrovibration.skin.relaxation import Solution

    return Solution(voltage, form.relaxations).at(t_s)


def spectrum_stage(name: str, record: str, gives: str) -> Stage:
    """Return the stage that reads a record's components in a scene."""
    return Stage(name, ("t_s", record), gives, f"{RECORD}:components_of", size=_fine_spectrum)


def spectrum_of_record(name: str, course: str, gives: str) -> Stage:
    """Return the stage that reads a played record's components."""
    return Stage(name, ("record", course), gives, f"{RECORD}:components_of_record", size=_fine_spectrum_of_record)


def _fine_spectrum(demand: Demand) -> Size:
    from .record import size  # components are needed only for a threshold

    return size(demand)


def _fine_spectrum_of_record(demand: Demand) -> Size:
    from .record import size_of_record

    return size_of_record(demand)


def at_voltage(name: str, per_volt: str, gives: str, size: Callable[[Demand], Size] | None = None) -> Stage:
    """Return the stage that scales a quantity per volt to a run."""
    return Stage(name, (per_volt, "voltage_v"), gives, MULTIPLY, size=size)


def highest(course: "FloatArray") -> float:
    """Return the largest value of a course (n,)."""
    return float(course.max())
