"""Stages that read the components of a record, as finely as a threshold asks for."""

from ...composition.effect import Demand, Size, Stage

COMPONENTS, OF_RECORD = (
    "tactometry.stimuli.scenes.stages.spectrum:components_of",
    "tactometry.stimuli.scenes.stages.record:components_of",
)


def spectrum_stage(name: str, record: str, gives: str) -> Stage:
    """Of a course at the times of a scene."""
    return Stage(name, ("t_s", record), gives, COMPONENTS, size=fine_spectrum)


def spectrum_of_record(name: str, course: str, gives: str) -> Stage:
    """Of a course over a voltage that is played."""
    return Stage(name, ("record", course), gives, OF_RECORD, size=fine_spectrum_of_record)


def fine_spectrum(demand: Demand) -> Size:
    """Asked for by a threshold; without one, reading is not imported."""
    from .spectrum import size

    return size(demand)


def fine_spectrum_of_record(demand: Demand) -> Size:
    """The same over a voltage that is played."""
    from .record import reading

    return reading(demand)
