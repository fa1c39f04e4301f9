"""Sigma-delta modulation of the reversed responses."""

from dataclasses import dataclass

from tactometry.arguments.checked import Matrix, Positive, checked
from tactometry.arguments.require import expect
from tactometry.errors import LimitExceeded

from ...arrays import FloatArray
from ...composition.effect import Quantity


@checked
@dataclass(frozen=True)
class SigmaDelta(Quantity):
    """One bit per sample whose quantisation noise is pushed to high frequencies.

    Raises `InvalidParameter` if the order or scale is invalid. `quantise` raises `LimitExceeded` if the modulator
    overloads.

    Parameters
    ----------
    order : int
        Order of the modulator's loop filter: 1 or 2.
    scale : float
        Peak of the modulator's input, above 0; the first order is stable up to 1, the second at 0.7 up to a 20th of the
        rate.
    """

    kind, slot, gives = "sigma_delta", "quantiser", "quantiser"
    in_signal = True

    order: int = 2
    scale: Positive = 0.7

    def __post_init__(self) -> None:
        expect(self.order in (1, 2), "SigmaDelta.order", self.order, "1 or 2")

    def quantise(self, waveform: Matrix, rate_hz: float) -> FloatArray:
        from .modulator import modulate
        from .quantiser import normalised

        del rate_hz
        stream = modulate(self.scale * normalised(waveform), self.order)
        if stream.overloaded:
            raise LimitExceeded(
                f"SigmaDelta(order={self.order}, scale={self.scale}): found a state of "
                f"{stream.peak_state:.3g}, the limit is {stream.limit:.3g}: the modulator overloads; "
                "lower scale (0.7 is stable for a sine up to a 20th of the rate), or raise the rate; nothing is emitted"
            )
        return stream.bits.astype(float)
