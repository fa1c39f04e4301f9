"""Foci repeated under an envelope: the thesis's patterns."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, get_args

from tactometry.arguments import require

from ...composition.content import PlateContent
from ...composition.effect import Demand, Effect, Size, Surroundings
from ...defaults import REPETITION_HZ, TRAIN_S

if TYPE_CHECKING:
    from ...time_reversal.focusing.quantiser import Quantiser
    from ...time_reversal.responses.responses import Responses
    from ..stages.emission import EmittedSignal

Envelope = Literal["rectangular", "raised_cosine", "exponential", "sinc"]


@dataclass(frozen=True)
class Repetition(Effect):
    """A train of foci under an envelope; every default is unverified.

    Parameters
    ----------
    repetition_hz : float
        Number of foci per second.
    duration_s : float
        Duration of the train.
    envelope : str
        Course of the foci's weights over the train.
    """

    kind = "repetition"
    in_signal = True
    reads, gives = ("learnt", "quantiser"), "emission"
    positive = ("repetition_hz", "duration_s")

    repetition_hz: float = REPETITION_HZ
    duration_s: float = TRAIN_S
    envelope: Envelope = "rectangular"

    def __post_init__(self) -> None:
        super().__post_init__()
        require.one_of("Repetition.envelope", self.envelope, get_args(Envelope))

    @property
    def n(self) -> int:
        """Number of foci."""
        return max(round(self.duration_s * self.repetition_hz), 1)

    def __call__(self, learnt: "Responses", quantiser: "Quantiser") -> "EmittedSignal":
        """Return the emission of a train; its focus instant is the largest focus."""
        from ...time_reversal.focusing import pattern as patterns
        from ..stages.emission import EmittedSignal

        train = patterns.Pattern(self.repetition_hz, self.duration_s, patterns.ENVELOPES[self.envelope])
        together = replace(learnt, samples=learnt.samples.sum(axis=0, keepdims=True))
        signal = patterns.pattern_drive(together, train, 1.0, quantiser)
        foci = patterns.focus_samples(train, learnt.rate_hz, learnt.n_samples)
        return EmittedSignal(signal.samples, learnt.rate_hz, int(foci[abs(train.weights).argmax()]))

    def size(self, demand: Demand) -> Size:
        surface = demand.surface
        return Size(n_operations=20.0 * self.n * surface.n_transducers * surface.rate_hz * surface.reversal_s)

    def in_plate(self, scene: Surroundings) -> PlateContent:
        """Return the weakening of overlapping emissions, which share the voltage."""
        overlap = min(scene.surface.reversal_s, self.duration_s) * self.repetition_hz
        return PlateContent(weakening=max(1.0, overlap), train_s=self.duration_s)
