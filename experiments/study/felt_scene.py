"""A scene as the skin of a simulated participant."""

from dataclasses import dataclass
from functools import cached_property

from tactometry.contact import Contact
from tactometry.signal import Signal
from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.scenes.plan import Plan
from tactometry.stimuli.scenes.scene import Scene

FORCE = "contact_force_n"


@dataclass(frozen=True, eq=False)
class FeltScene:
    """What a finger feels through a scene.

    Parameters
    ----------
    scene : Scene
    """

    scene: Scene

    def sensation_db(self, signal: Signal, contact: Contact) -> float:
        """Sensation level (dB) of a signal under a finger."""
        return self.scene.sensation(signal, contact)


class FeltOnPlate(FeltScene):
    """The same on a plate that moves: it knows the force between finger and plate too."""

    def contact_force_n(self, signal: Signal, contact: Contact) -> FloatArray:
        """(n_fingers, n_samples): what a linear contact does to each finger on top of its force, as the scene loads the
        plate, or as by default where it does not."""
        force_n: FloatArray = self._pressed.run({"signal": signal, "contact": contact})[FORCE]
        return force_n

    @property
    def pressers(self) -> tuple[str, ...]:
        """The fingers that share the force of a touch, in words."""
        return tuple(f"finger at {name}" for name in self.scene.surface.names) or ("finger",)

    @cached_property
    def _pressed(self) -> Plan:
        return self.scene.felt(FORCE).resolve()


class FeltByFingers(FeltOnPlate):
    """The same under fingers, which tell where they feel something."""

    def fingers_db(self, signal: Signal, contact: Contact) -> tuple[float, ...]:
        """The level (dB) at each finger."""
        return self.scene.fingers_db(signal, contact)


def felt(scene: Scene) -> FeltScene:
    """A scene as it is felt on its surface."""
    if scene.surface.names:
        return FeltByFingers(scene)
    kind = FeltScene if scene.surface.kind == "electrovibration" else FeltOnPlate
    return kind(scene)
