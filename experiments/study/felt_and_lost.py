"""What is told of a study's touch: which effects are felt, and where the plate throws a finger off."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from .contact_loss import FingerOfStudy, pulled_fingers
from .experiment import Experiment

if TYPE_CHECKING:
    from .felt_effects import FeltEffects


@dataclass(frozen=True)
class FeltAndLost:
    """Of each choice of effects what is felt, each finger that is pulled, and the models through which it is felt."""

    effects: "tuple[FeltEffects, ...]"
    fingers: tuple[FingerOfStudy, ...]
    models: tuple[str, ...]

    @property
    def lines(self) -> list[str]:
        """In words."""
        felt = [line for effects in self.effects for line in effects.lines]
        return [*(felt or [f"felt by {', '.join(self.models)}, no scene"]), *(finger.line for finger in self.fingers)]

    @property
    def record(self) -> dict[str, list[dict[str, Any]]]:
        """As a result in JSON; contact alone where a finger is pulled."""
        contact = [asdict(finger) for finger in self.fingers]
        return {"felt": [asdict(effects) for effects in self.effects], **({"contact": contact} if contact else {})}


def felt_and_lost(experiment: Experiment) -> FeltAndLost:
    """What participants feel of a study at its strongest levels, and what the plate throws off.

    >>> from .experiment import wire
    >>> from .study_file import load
    >>> felt_and_lost(wire(load("tutorial")[0], "tutorial")).lines[0][:15]
    'felt of amplitu'
    """
    from .felt_effects import felt_effects

    models = {type(cell.sensation).__name__ for cell in experiment.cells.values()}
    return FeltAndLost(tuple(felt_effects(experiment)), tuple(pulled_fingers(experiment)), tuple(sorted(models)))
