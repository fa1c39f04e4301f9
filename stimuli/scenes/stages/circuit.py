"""The voltage across a layer: a divider without losses, or the exact answer of a circuit with some."""

from typing import TYPE_CHECKING

from tactometry.errors import InvalidParameter

from ...composition.effect import Demand, Size, Stage
from ...composition.sampling import per_sample

if TYPE_CHECKING:
    from ...arrays import FloatArray
    from ...electrovibration.attraction.force import ForceForm
    from ...electrovibration.waveforms.pieces import Pieces

NEEDS = ("t_s", "unit_voltage", "form")


def divider_stage() -> Stage:
    """The layer's share of the voltage: what holds without losses."""
    return Stage("divider", NEEDS, "unit_layer_voltage_v", f"{__name__}:divider", size=per_sample(700.0))


def circuit_stage(effect: str) -> Stage:
    """The exact relaxations of the layers, for an effect with a loss in it; see `check_ramp`."""

    def size(demand: Demand) -> Size:
        check_ramp(demand, effect)
        return per_sample(1500.0)(demand)

    return Stage("circuit", NEEDS, "unit_layer_voltage_v", f"{__name__}:relaxation", size=size)


def of_true_area() -> Stage:
    """The law of force under the area of the contact, in place of one that is scaled by it."""
    return Stage("true_area", ("area_m2",), "form_area_m2", f"{__name__}:same")


def same(area_m2: float) -> float:
    """An area under another name."""
    return area_m2


def check_ramp(demand: Demand, effect: str) -> None:
    """Refuse a tone without a ramp: what then relaxes is faster than the tone that the sampling is chosen for."""
    if not demand.surface.ramp_s:
        raise InvalidParameter(
            f"{effect}: found a tone that sets in at once (ramp_s = 0), expected a ramp; give the tone a ramp_s above 0"
        )


def divider(t_s: "FloatArray", voltage: "Pieces", form: "ForceForm") -> "FloatArray":
    """Layers without losses divide a voltage at any frequency alike."""
    gain = sum(form.relaxations.gains, start=form.relaxations.dc_gain)
    return gain * voltage.at(t_s)


def relaxation(t_s: "FloatArray", voltage: "Pieces", form: "ForceForm") -> "FloatArray":
    """The exact solution of the circuit."""
    from ...electrovibration.skin.solution import Solution

    return Solution(voltage, form.relaxations).at(t_s)
