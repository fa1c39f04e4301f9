"""A scene as the skin of a simulated participant."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from tactometry.contact import Contact
from tactometry.signal import Signal
from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.scenes.scene import Scene


@dataclass(frozen=True, eq=False)
class FeltScene:
    """What a finger feels through a scene.

    Parameters
    ----------
    scene : Scene
    model : object, optional
        The model of `[sensation]` that the scene stands for; None of a scene that the study states.
    """

    scene: Scene
    model: Any = None

    def sensation_db(self, signal: Signal, contact: Contact) -> float:
        """Sensation level (dB) of a signal under a finger."""
        return self.scene.sensation(signal, contact)


class FeltOnPlate(FeltScene):
    """The same on a plate that moves: it knows the force between finger and plate too."""

    def contact_force_n(self, signal: Signal, contact: Contact) -> FloatArray:
        """(n_samples,): what a linear contact does to the finger on top of its force, as the scene loads the plate, or
        as by default where it does not."""
        force_n: FloatArray = self._pressed.contact_force_n(signal, contact)
        return force_n

    @cached_property
    def _pressed(self) -> Any:
        if self.model is not None:
            return self.model
        from tactometry.stimuli.hybrid import HybridSensation
        from tactometry.stimuli.time_reversal.stimulus.sensation import TimeReversalSensation

        surface: Any = self.scene.surface
        if surface.kind == "hybrid":
            return HybridSensation(surface.time_reversal.setup)
        load = self.scene.find("load")
        place = {"finger_x_m": surface.finger_x_m, "finger_y_m": surface.finger_y_m}
        return TimeReversalSensation(surface.setup, **place, **({} if load is None else vars(load)))


def felt(scene: Scene, model: Any = None) -> FeltScene:
    """A scene as it is felt on its surface."""
    kind = FeltScene if scene.surface.kind == "electrovibration" else FeltOnPlate
    return kind(scene, model)
