"""Electrovibration screens, computed from a level or a played signal."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar

from tactometry.arguments import require
from tactometry.contact import Contact

from ...composition.effect import PLAYED, Demand, FingerContact, Size, Stage, Surface, Surroundings, is_changed
from ...composition.sampling import per_sample, record
from ..effects import OF_ELECTROVIBRATION
from ..stages.circuit import HIGHEST, MULTIPLY, divider_stage, of_true_area, spectrum_of_record, spectrum_stage

if TYPE_CHECKING:
    from ...arrays import FloatArray
    from ...electrovibration.skin.skin import Skin
    from ...electrovibration.waveforms.pieces import Pieces
    from ...electrovibration.waveforms.waveform import Waveform

ASSUMES: Mapping[str, str] = {
    "body": "no resistance of body and source",
    "leakage": "a corneum without losses",
    "gap": "no air between insulator and skin",
    "area": "a contact area that does not depend on force",
    "mobility": "a pulp with stiffness, damping and mass from memory, unless finger_dynamics moves the skin",
    "polarity": "the same attraction for both signs of the voltage",
}

AREA_M2 = 1e-4
"""Contact area; source: `contact_area` in `stimuli/sources.toml`."""

SKIN_MOTION = Stage(
    "skin_motion",
    ("components", "contact"),
    "skin_components",
    "tactometry.stimuli.electrovibration.motion.skin_mobility:SkinMobility",
)
"""Motion of the skin by the default `SkinMobility`."""

WAVEFORMS = "tactometry.stimuli.electrovibration.waveforms"
FORCE = "tactometry.stimuli.electrovibration.attraction.force:ForceForm.force_n"
SAME = "tactometry.stimuli.scenes.stages.circuit:same"
RECORD = "tactometry.stimuli.scenes.stages.record"


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
        Contact area, unless an effect makes it depend on force; 1 cm^2 is from memory.
    insulator_thickness_m, insulator_permittivity, corneum_thickness_m, corneum_permittivity : float
        As in `tactometry.stimuli.electrovibration.Skin`.

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

    def stages(self, scene: Demand) -> tuple[Stage, ...]:
        tone = {"frequency_hz": self.frequency_hz, "duration_s": self.duration_s, "ramp_s": self.ramp_s}
        of_layer, force = ("unit_layer_voltage_v", "peak_voltage_v"), ("electrostatic_force_n",)
        drawn, once = ("form", "layer_voltage_v"), per_sample(1.0)
        first = [{"force_n": touch.force_n, "speed_m_per_s": touch.speed_m_per_s} for touch in scene.contacts[:1]]

        return (
            Stage("waveform", (), "waveform", f"{__name__}:tone", tone),
            Stage("unit_voltage", ("waveform",), "unit_voltage", f"{__name__}:of_one_volt"),
            Stage("level", ("level_db_re_1v",), "peak_voltage_v", f"{WAVEFORMS}.waveform:peak_voltage_v"),
            Stage("voltage", ("unit_voltage", "peak_voltage_v"), "voltage", f"{WAVEFORMS}.pieces:Pieces.scaled"),
            Stage("sampling", ("unit_voltage",), "t_s", f"{__name__}:grid", size=record),
            Stage("drive", ("voltage", "t_s"), "voltage_v", f"{WAVEFORMS}.pieces:Pieces.at", size=per_sample(700.0)),
            *(Stage("contact", (), "contact", f"{__name__}:contact", finger) for finger in first),
            Stage("skin", (), "skin", f"{__name__}:lossless", self._skin()),
            Stage("area", (), "area_m2", f"{__name__}:constant", {"value": self.area_m2}),
            divider_stage(),
            Stage("layer_voltage", of_layer, "layer_voltage_v", MULTIPLY, size=once),
            Stage("attraction", drawn, "electrostatic_force_n", FORCE, size=per_sample(3.0)),
            spectrum_stage("spectrum", "friction_force_n", "components"),
            SKIN_MOTION,
            Stage("peak", force, "peak_force_n", HIGHEST, size=once),
        )

    def played(self, scene: Surroundings | None = None) -> "PlayedElectrovibration":
        """Return the panel that plays any voltage."""
        return PlayedElectrovibration(lossless(**self._skin()), self.area_m2, self.duration_s)

    def _skin(self) -> dict[str, float]:
        return {name: value for name, value in vars(self).items() if name.startswith(("insulator", "corneum"))}


def contact(force_n: float, speed_m_per_s: float) -> Contact:
    return Contact(force_n, speed_m_per_s)


def tone(frequency_hz: float, duration_s: float, ramp_s: float) -> "Waveform":
    from ...electrovibration.waveforms.sine import Sine

    return Sine(frequency_hz, duration_s, ramp_s, rate_hz=max(20_000.0, 4 * frequency_hz))


def of_one_volt(waveform: "Waveform") -> "Pieces":
    """Return the exact voltage at 0 dB re 1 V."""
    return waveform.pieces(0.0)


def grid(voltage: "Pieces", n_samples: int) -> "FloatArray":
    """Return equally spaced times from start to end of a voltage."""
    import numpy as np

    return np.linspace(0.0, voltage.end_s, n_samples)


def lossless(**layers: Any) -> "Skin":
    from ...electrovibration.skin.skin import Skin

    return Skin(**layers, corneum_resistivity_ohm_m=inf)


def constant(value: float) -> float:
    return value


@dataclass(frozen=True)
class PlayedElectrovibration(Surface):
    """A panel that plays any voltage, one channel of samples.

    Stages that depend only on the voltage use a contact of 1 m^2: area, friction and lag are factors of the components.
    Effects for which this does not hold (a body in series, a finger that sticks, a changed course of friction) use the
    true area.

    Parameters
    ----------
    skin : Skin
        Insulator, corneum and tissue; leakage, gap and resistance are effects.
    area_m2 : float
        Contact area, unless an effect makes it depend on force.
    duration_s : float
        Duration of a record, which sets the resolution of its spectrum.

    >>> PlayedElectrovibration().given
    ('signal', 'contact')
    """

    kind = "electrovibration"
    is_played, given = True, PLAYED
    effects = OF_ELECTROVIBRATION
    assumes: ClassVar[Mapping[str, str]] = ASSUMES
    touches = (FingerContact(1.0, 0.05),)

    skin: "Skin" = field(default_factory=lossless)
    area_m2: float = AREA_M2
    duration_s: float = 1.0

    def stages(self, scene: Demand) -> tuple[Stage, ...]:
        area, drawn = ("attraction_components", "area_m2", "form_area_m2"), ("form", "layer_voltage_v")
        tissue = self.skin.tissue
        layers = {**vars(self.skin), "tissue": tuple(vars(tissue).values()) if tissue else ()}

        return (
            Stage("record", ("signal",), "record", f"{RECORD}:recorded", size=_sampling),
            Stage("times", ("record",), "t_s", f"{RECORD}:times"),
            Stage("pieces", ("record",), "voltage", f"{RECORD}:pieces"),
            Stage("skin", (), "skin", f"{RECORD}:skin", layers),
            Stage("area", (), "area_m2", SAME, {"area_m2": self.area_m2}),
            Stage("unit_area", (), "form_area_m2", SAME, {"area_m2": 1.0}),
            Stage("layer_voltage", ("record", "form"), "layer_voltage_v", f"{RECORD}:layer_voltage"),
            Stage("attraction", drawn, "electrostatic_force_n", FORCE),
            spectrum_of_record("spectrum", "electrostatic_force_n", area[0]),
            Stage("area_factor", area, area[0], f"{RECORD}:grown"),
            spectrum_of_record("spectrum_of_friction", "friction_force_n", "components"),
            SKIN_MOTION,
            *((of_true_area(),) if is_changed("friction_force_n", scene) else ()),
        )

    def reaches(self, contact: Contact) -> bool:
        """Return True for a sliding finger, as only that feels friction."""
        return contact.force_n > 0 and contact.speed_m_per_s > 0


def _sampling(demand: Demand) -> Size:
    return Size({"share": demand.error**2}, demand.error)
