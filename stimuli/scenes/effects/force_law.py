"""Choice of an electrostatic force law; the four differ by up to 1000."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, get_args

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from ...composition.effect import Effect, Stage, Surroundings, note

if TYPE_CHECKING:
    from ...electrovibration.attraction.force import ForceForm
    from ...electrovibration.skin.skin import Skin

Law = Literal["parallel_plate", "interface", "total_thickness", "sc_layer"]
LAYERLESS = ("parallel_plate", "total_thickness")
BARRED = ("gap", "leakage", "body")


@dataclass(frozen=True)
class ForceLaw(Effect):
    """Choice of the electrostatic force law.

    Parameters
    ----------
    law : str
        Name of the force law, as in `tactometry.stimuli.electrovibration.electrostatic_force_n`.
    """

    kind = "force_law"
    slot = "law"
    reads, gives = ("skin", "area_m2"), "form"
    cures = note(
        "add the effect force_law and name one of the four laws; their forces differ by a factor near 1000", "form"
    )
    rests_on = "the force law (one of four, which differ by a factor near 1000)"

    law: Law

    def __post_init__(self) -> None:
        require.one_of("ForceLaw.law", self.law, get_args(Law))

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        barred = [effect.kind for slot in BARRED if (effect := scene.find(slot)) is not None]
        if self.law in LAYERLESS and barred:
            raise InvalidParameter(
                f"force_law: found {self.law!r} with {barred[0]!r}, which that law ignores, expected the law "
                f"interface or sc_layer; or remove {barred[0]!r}"
            )
        return super().stages(scene)

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return the stage for unit area, which is then scaled to each contact."""
        (drawn,) = self.stages(scene)
        return (replace(drawn, needs=("skin", "form_area_m2")),)

    def __call__(self, skin: "Skin", area_m2: float) -> "ForceForm":
        from ...electrovibration.attraction.force import force_form

        return force_form(self.law, skin, area_m2)
