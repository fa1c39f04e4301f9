"""Which of the four laws of the literature gives the electrostatic force; they differ by a factor near 1000."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...electrovibration.attraction.force import ForceForm
    from ...electrovibration.skin.skin import Skin

Law = Literal["parallel_plate", "interface", "total_thickness", "sc_layer"]
LAYERLESS = ("parallel_plate", "total_thickness")
BARRED = ("gap", "leakage", "body")


@dataclass(frozen=True)
class ForceLaw(Effect):
    """A law by its name, as in `tactometry.stimuli.electrovibration.electrostatic_force_n`.

    >>> ForceLaw("sc_layer").law
    'sc_layer'
    """

    kind = "force_law"
    slot = "law"
    assumes = ("one force law of four, which differ by a factor near 1000",)

    law: Law

    def __post_init__(self) -> None:
        require.one_of("ForceLaw.law", self.law, get_args(Law))

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        self._check_terms(scene)
        needs, target = ("skin", "area_m2"), f"{__name__}:form"
        return (Stage("force_law", needs, "form", target, {"law": self.law}),)

    def _check_terms(self, scene: Surroundings) -> None:
        found = [effect.kind for slot in BARRED if (effect := scene.find(slot)) is not None]
        if self.law in LAYERLESS and found:
            raise InvalidParameter(
                f"force_law: found {self.law!r} beside {found[0]!r}, for which that law has no term, expected the law "
                f"interface or sc_layer; or remove {found[0]!r}"
            )


def form(law: Law) -> "Callable[[Skin, float], ForceForm]":
    """The law on a skin and an area."""
    from ...electrovibration.attraction.force import force_form

    return lambda skin, area_m2: force_form(law, skin, area_m2)
