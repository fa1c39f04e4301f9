"""An amplifier with a roll-off, in learning and in emission."""

from dataclasses import dataclass

from ...composition.effect import Effect, Stage, Surroundings

EMISSION = "tactometry.stimuli.scenes.stages.emission"


@dataclass(frozen=True)
class Amplifier(Effect):
    """An amplifier with a Butterworth low-pass; both defaults are unverified.

    Parameters
    ----------
    cutoff_hz : float
        Frequency at which the gain is -3 dB.
    order : int
        Order of the Butterworth filter.
    """

    kind = "amplifier"
    in_signal = True
    positive = ("cutoff_hz", "order")

    cutoff_hz: float = 60e3
    order: int = 1

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        settings = dict(vars(self))
        return (
            Stage("amplifier_in", ("learnt",), "learnt", f"{EMISSION}:amplified_responses", settings),
            Stage("amplifier_out", ("in_band",), "in_band", f"{EMISSION}:amplified", settings),
        )
