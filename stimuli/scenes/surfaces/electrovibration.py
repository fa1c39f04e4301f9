"""An electrovibration screen: from a level to the attraction of a finger, with whatever effects are called for."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from tactometry.arguments import require
from tactometry.contact import Contact

from ...composition.effect import Stage, Surface
from ...composition.sampling import per_sample, record
from ..effects import OF_ELECTROVIBRATION
from ..stages.circuit import divider_stage
from ..stages.reading import spectrum_stage
from ..stages.scaling import HIGHEST, MULTIPLY
from .panel import AREA_M2, ASSUMES, SKIN_MOTION

if TYPE_CHECKING:
    from ...arrays import FloatArray
    from ...composition.effect import Demand, Surroundings
    from ...electrovibration.skin.skin import Skin
    from ...electrovibration.waveforms.pieces import Pieces
    from ...electrovibration.waveforms.waveform import Waveform
    from .played_electrovibration import PlayedElectrovibration

WAVEFORMS = "tactometry.stimuli.electrovibration.waveforms"
FORCE = "tactometry.stimuli.electrovibration.attraction.force:ForceForm.force_n"


@dataclass(frozen=True)
class Electrovibration(Surface):
    """A sine on a coated electrode under a skin without losses.

    Parameters
    ----------
    frequency_hz : float
        Frequency of the tone, above 0.
    duration_s : float
        Duration of the tone, above 0.
    ramp_s : float
        Duration of the tone's rise and of its fall, at least 0.
    area_m2 : float
        Contact area, as long as no effect makes it depend on force; 1 cm^2 is an unverified default.
    insulator_thickness_m, insulator_permittivity, corneum_thickness_m, corneum_permittivity : float
        As in `tactometry.stimuli.electrovibration.Skin`.

    Raises
    ------
    InvalidParameter
        If a value is outside of its domain.

    >>> Electrovibration(frequency_hz=240.0).given
    ('level_db_re_1v',)
    """

    kind = "electrovibration"
    effects = OF_ELECTROVIBRATION
    given = ("level_db_re_1v",)
    assumes: ClassVar[Mapping[str, str]] = ASSUMES

    frequency_hz: float
    duration_s: float = 1.0
    ramp_s: float = 0.05
    area_m2: float = AREA_M2
    insulator_thickness_m: float = 1e-6
    insulator_permittivity: float = 3.9
    corneum_thickness_m: float = 200e-6
    corneum_permittivity: float = 1000.0

    def __post_init__(self) -> None:
        values = {name: value for name, value in vars(self).items() if name != "ramp_s"}
        require.positive("Electrovibration", **values)
        require.not_negative("Electrovibration", ramp_s=self.ramp_s)

    def stages(self, scene: "Demand") -> tuple[Stage, ...]:
        tone = {"frequency_hz": self.frequency_hz, "duration_s": self.duration_s, "ramp_s": self.ramp_s}
        of_layer, force = ("unit_layer_voltage_v", "peak_voltage_v"), ("electrostatic_force_n",)
        drawn, once = ("form", "layer_voltage_v"), per_sample(1.0)
        return (
            Stage("waveform", (), "waveform", f"{__name__}:tone", tone),
            Stage("unit_voltage", ("waveform",), "unit_voltage", f"{__name__}:of_one_volt"),
            Stage("level", ("level_db_re_1v",), "peak_voltage_v", f"{WAVEFORMS}.waveform:peak_voltage_v"),
            Stage("voltage", ("unit_voltage", "peak_voltage_v"), "voltage", f"{WAVEFORMS}.pieces:Pieces.scaled"),
            Stage("sampling", ("unit_voltage",), "t_s", f"{__name__}:grid", size=record),
            Stage("drive", ("voltage", "t_s"), "voltage_v", f"{WAVEFORMS}.pieces:Pieces.at", size=per_sample(700.0)),
            *_finger(scene),
            Stage("skin", (), "skin", f"{__name__}:lossless", self._skin()),
            Stage("area", (), "area_m2", f"{__name__}:constant", {"value": self.area_m2}),
            divider_stage(),
            Stage("layer_voltage", of_layer, "layer_voltage_v", MULTIPLY, size=once),
            Stage("attraction", drawn, "electrostatic_force_n", FORCE, size=per_sample(3.0)),
            spectrum_stage("spectrum", "friction_force_n", "components"),
            SKIN_MOTION,
            Stage("peak", force, "peak_force_n", HIGHEST, size=once),
        )

    def played(self, scene: "Surroundings | None" = None) -> "PlayedElectrovibration":
        """The panel under whatever voltage is played."""
        from .played_electrovibration import PlayedElectrovibration

        return PlayedElectrovibration(lossless(**self._skin()), self.area_m2, self.duration_s)

    def _skin(self) -> dict[str, float]:
        return {name: value for name, value in vars(self).items() if name.startswith(("insulator", "corneum"))}


def _finger(scene: "Demand") -> tuple[Stage, ...]:
    """The first finger, whose force and speed effects read."""
    settings = [{"force_n": touch.force_n, "speed_m_per_s": touch.speed_m_per_s} for touch in scene.contacts[:1]]
    return tuple(Stage("contact", (), "contact", f"{__name__}:contact", of_one) for of_one in settings)


def contact(force_n: float, speed_m_per_s: float) -> Contact:
    """A finger on the panel."""
    return Contact(force_n, speed_m_per_s)


def tone(frequency_hz: float, duration_s: float, ramp_s: float) -> "Waveform":
    """A sine with ramps."""
    from ...electrovibration.waveforms.sine import Sine

    return Sine(frequency_hz, duration_s, ramp_s, rate_hz=max(20_000.0, 4 * frequency_hz))


def of_one_volt(waveform: "Waveform") -> "Pieces":
    """The voltage of level 0 dB re 1 V, exactly."""
    return waveform.pieces(0.0)


def grid(voltage: "Pieces", n_samples: int) -> "FloatArray":
    """Equal steps from the beginning to the end of a voltage."""
    import numpy as np

    return np.linspace(0.0, voltage.end_s, n_samples)


def lossless(**layers: Any) -> "Skin":
    """A skin whose corneum does not conduct."""
    from math import inf

    from ...electrovibration.skin.skin import Skin

    return Skin(**layers, corneum_resistivity_ohm_m=inf)


def constant(value: float) -> float:
    """A number that nothing changes."""
    return value
