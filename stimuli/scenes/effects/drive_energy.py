"""Energy in the plate and power drawn by the transducers."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tactometry.arguments.require import expect

from ...composition.effect import Demand, Effect, Size, Stage, Surroundings, note
from ...time_reversal.screen.transducer import PATCH_CAPACITANCE_F, PZ27_LOSS_TANGENT
from ..stages.truncation import MOST_MODES, n_modes, remainder

if TYPE_CHECKING:
    from ..stages.emission import EmittedSignal

STRAIN = "tactometry.stimuli.scenes.stages.motion:PlateMotion.strain_energy_j"


@dataclass(frozen=True)
class DriveEnergy(Effect):
    """Strain energy in the band, and the electrical power of transducers of `capacitance_f`.

    A switching drive (an effect of the slot ``quantiser``) loses C dV^2 / 2 in each step. Other drives lose the
    dielectric heat given by `loss_tangent`. The unverified defaults, 5.31 nF and 0.017, are those of 1 cm^2 of PZ27,
    0.3 mm thick.

    Parameters
    ----------
    capacitance_f : float
        Capacitance of one transducer.
    loss_tangent : float
        Loss tangent of the transducer's dielectric.
    """

    kind = "drive_energy"
    slot = "energy"
    positive = ("capacitance_f", "loss_tangent")
    cures = note("add the effect drive_energy", "energy_j", "power_w")

    capacitance_f: float = PATCH_CAPACITANCE_F
    loss_tangent: float = PZ27_LOSS_TANGENT

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        if scene.find("quantiser") is not None:
            settings = {"capacitance_f": self.capacitance_f}
            drawn = Stage("switching", ("emission",), "power_at_1v_w", f"{__name__}:switching_w", settings)
        else:
            drawn = Stage("heating", ("emission", "in_band"), "power_at_1v_w", f"{__name__}:heat_w", dict(vars(self)))

        return (
            Stage("strain_energy", ("motion",), "energy_at_1v_j", STRAIN, size=_strain_size),
            _squared("energy", "energy_at_1v_j", "energy_j"),
            drawn,
            _squared("power", "power_at_1v_w", "power_w"),
        )


def _strain_size(demand: Demand) -> Size:
    surface = demand.surface
    lost = 4 * remainder(demand) ** 2
    ratio = max(4.0, 1.01 * lost / demand.error)
    static_to_hz = ratio * surface.f_max_hz
    n = n_modes(demand, static_to_hz)
    expected = f"at most {MOST_MODES:.2g}; loosen the accuracy"
    expect(n <= MOST_MODES, "energy_j", f"an error budget of {demand.error:.2g}, which takes {n:.2g} modes", expected)
    return Size({"static_to_hz": static_to_hz}, lost / ratio, 4.0 * n * surface.n_transducers)


def _squared(name: str, at_1v: str, gives: str) -> Stage:
    return Stage(name, (at_1v, "voltage_v"), gives, f"{__name__}:growth_with_square")


def switching_w(emission: "EmittedSignal", capacitance_f: float) -> float:
    """Return the mean power during an emission of 1 V."""
    from ...time_reversal.focusing.merit import switched_power_w

    return switched_power_w(emission.at_1_v, capacitance_f)


def heat_w(emission: "EmittedSignal", in_band: "EmittedSignal", capacitance_f: float, loss_tangent: float) -> float:
    """Return the mean dielectric loss in the band during an emission of 1 V."""
    from ...time_reversal.focusing.merit import dielectric_power_w

    longer: float = in_band.samples.shape[1] / emission.samples.shape[1]
    return longer * dielectric_power_w(in_band.at_1_v, capacitance_f, loss_tangent)


def growth_with_square(at_1v: float, voltage_v: float) -> float:
    return at_1v * voltage_v**2
