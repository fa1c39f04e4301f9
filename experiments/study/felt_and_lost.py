"""What is told of a study's touch: which effects are felt, and where the plate throws a finger off."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from .contact_loss import FingerOfStudy, pulled_fingers
from .experiment import Experiment

if TYPE_CHECKING:
    from .felt_effects import FeltEffects
    from .predicted_jnd import PredictedJnd
    from .unfelt import Unfelt


@dataclass(frozen=True)
class FeltAndLost:
    """Of each choice of effects what is felt, each finger that is pulled, the models through which it is felt, the
    conditions whose strongest level is below threshold, and the just noticeable differences of a comparison."""

    effects: "tuple[FeltEffects, ...]"
    fingers: tuple[FingerOfStudy, ...]
    models: tuple[str, ...]
    unfelt: "tuple[Unfelt, ...]" = ()
    jnds: "tuple[PredictedJnd, ...]" = ()

    @property
    def warnings(self) -> list[str]:
        """A line for each condition that nobody is predicted to feel."""
        return [one.line for one in self.unfelt]

    @property
    def lines(self) -> list[str]:
        """In words."""
        felt = [line for effects in self.effects for line in effects.lines]
        through = felt or [f"felt by {', '.join(self.models)}, no scene"]
        return [*self.warnings, *(one.line for one in self.jnds), *through, *(finger.line for finger in self.fingers)]

    @property
    def record(self) -> dict[str, list[dict[str, Any]]]:
        """As a result in JSON; contact where a finger is pulled, conditions where nothing is felt."""
        contact, unfelt = [asdict(finger) for finger in self.fingers], [asdict(one) for one in self.unfelt]
        jnds = [asdict(one) for one in self.jnds]
        further = {name: told for name, told in (("contact", contact), ("unfelt", unfelt), ("jnd", jnds)) if told}
        return {"felt": [asdict(effects) for effects in self.effects], **further}


def felt_and_lost(experiment: Experiment) -> FeltAndLost:
    """What participants feel of a study at its strongest levels, and what the plate throws off.

    >>> from .experiment import wire
    >>> from .study_file import load
    >>> felt_and_lost(wire(load("tutorial")[0], "tutorial")).lines[0][:15]
    'predicted for a'
    """
    from .felt_effects import felt_effects
    from .predicted_jnd import predicted_jnds
    from .unfelt import unfelt

    models = {type(cell.sensation).__name__ for cell in experiment.cells.values()}
    return FeltAndLost(
        tuple(felt_effects(experiment)),
        tuple(pulled_fingers(experiment)),
        tuple(sorted(models)),
        tuple(unfelt(experiment)),
        tuple(predicted_jnds(experiment)),
    )
