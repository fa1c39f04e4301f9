"""An electrovibration screen: from a level to the attraction of a finger, with whatever effects are called for."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from tactometry.arguments import require
from tactometry.contact import Contact
from tactometry.errors import InvalidParameter

from ...composition.effect import Effect, Size, Stage, Surface
from ...composition.sampling import per_sample, record
from ..effects import OF_ELECTROVIBRATION
from ..stages.circuit import divider_stage
from ..stages.scaling import HIGHEST, MULTIPLY

if TYPE_CHECKING:
    from tactometry.signal import Signal

    from ...arrays import FloatArray
    from ...composition.effect import Demand
    from ...electrovibration.skin.skin import Skin
    from ...electrovibration.waveforms.pieces import Pieces
    from ...electrovibration.waveforms.waveform import Waveform

SAME_VOLTAGE = 1e-6
"""Of the peak: what rounding of two ways to a voltage may leave between them."""
TINY = 1e-300
WAVEFORMS = "tactometry.stimuli.electrovibration.waveforms"
FORCE = "tactometry.stimuli.electrovibration.attraction.force:ForceForm.force_n"
COMPONENTS = "tactometry.stimuli.scenes.stages.spectrum:components_of"


@dataclass(frozen=True)
class Electrovibration(Surface):
    """A sine on a coated electrode under a skin without losses.

    Parameters
    ----------
    frequency_hz, duration_s, ramp_s : float
        Of the tone: above 0; the ramps at least 0.
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
    assumes: ClassVar[Mapping[str, str]] = {
        "body": "no resistance of body and source",
        "leakage": "a corneum without losses",
        "gap": "no air between insulator and skin",
        "area": "a contact area that no force changes",
        "polarity": "the same attraction at either sign of the voltage",
    }

    frequency_hz: float
    duration_s: float = 1.0
    ramp_s: float = 0.05
    area_m2: float = 1e-4
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
            Stage("skin", (), "skin", f"{__name__}:lossless", self._skin()),
            Stage("area", (), "area_m2", f"{__name__}:constant", {"value": self.area_m2}),
            divider_stage(),
            Stage("layer_voltage", of_layer, "layer_voltage_v", MULTIPLY, size=once),
            Stage("attraction", drawn, "electrostatic_force_n", FORCE, size=per_sample(3.0)),
            Stage("spectrum", ("t_s", "friction_force_n"), "components", COMPONENTS, size=fine_spectrum),
            Stage("peak", force, "peak_force_n", HIGHEST, size=once),
        )

    def played(self) -> "PlayedElectrovibration":
        """The panel under a signal that is played."""
        return PlayedElectrovibration(**vars(self))

    def reaches(self, contact: Contact) -> bool:
        """A finger at rest feels no friction."""
        return contact.force_n > 0 and contact.speed_m_per_s > 0

    def _skin(self) -> dict[str, float]:
        return {name: value for name, value in vars(self).items() if name.startswith(("insulator", "corneum"))}


@dataclass(frozen=True)
class PlayedElectrovibration(Electrovibration):
    """A panel whose level is that of the signal that is played: of its tone, at whatever rate it was sampled.

    >>> Electrovibration(frequency_hz=240.0).played().given
    ('signal',)
    """

    given = ("signal",)

    def stages(self, scene: "Demand") -> tuple[Stage, ...]:
        """A signal in place of the level."""
        needs, ramp = ("unit_voltage", "signal"), {"ramp_s": self.ramp_s}
        level = Stage("level", needs, "peak_voltage_v", f"{__name__}:peak_of_signal", ramp)
        return tuple(level if stage.name == level.name else stage for stage in super().stages(scene))

    def stages_of(self, effect: Effect, scene: "Demand") -> tuple[Stage, ...]:
        """As what is felt needs them."""
        return tuple(replace(stage, effect=effect.kind) for stage in effect.felt_stages(scene))


def tone(frequency_hz: float, duration_s: float, ramp_s: float) -> "Waveform":
    """A sine with ramps."""
    from ...electrovibration.waveforms.sine import Sine

    return Sine(frequency_hz, duration_s, ramp_s, rate_hz=max(20_000.0, 4 * frequency_hz))


def of_one_volt(waveform: "Waveform") -> "Pieces":
    """The voltage of level 0 dB re 1 V, exactly."""
    return waveform.pieces(0.0)


def peak_of_signal(unit: "Pieces", signal: "Signal", ramp_s: float) -> float:
    """The peak voltage at which the voltage of a scene is a signal, which nothing but its level may set apart.

    Samples end a step before the voltage does, and so does their last ramp: the level is that of the first half.
    """
    import numpy as np

    if signal.unit != "V" or len(signal.samples) != 1:
        raise InvalidParameter(
            f"signal: found {len(signal.samples)} channels in {signal.unit!r}, expected one channel in volt ('V')"
        )
    (voltage_v,) = signal.samples
    of_one_volt = unit.at(np.arange(voltage_v.size) / signal.rate_hz)
    half = of_one_volt[: voltage_v.size // 2]
    peak_v = float(half @ voltage_v[: half.size] / max(half @ half, TINY))
    beside = float(np.abs(voltage_v - peak_v * of_one_volt).max()) / signal.peak
    step_of_ramp = np.pi / (2 * ramp_s * signal.rate_hz) if ramp_s else 0.0
    if beside > step_of_ramp + SAME_VOLTAGE or abs(signal.duration_s - unit.end_s) > 1 / signal.rate_hz:
        raise InvalidParameter(
            f"signal: found a voltage of {signal.duration_s:g} s that is {beside:.2g} of its peak beside that of "
            f"the scene ({unit.end_s:g} s) at any level, expected the tone of the scene; state the same frequency, "
            "duration, ramps, phase and carrier"
        )
    return peak_v


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


def fine_spectrum(demand: "Demand") -> Size:
    """Components as finely as a threshold asks for; without one they are not imported."""
    from ..stages.spectrum import size

    return size(demand)
