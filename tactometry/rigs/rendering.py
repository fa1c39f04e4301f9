"""A stimulus by its name and level, as final samples within the limits of the study: one way for every rig."""

from collections.abc import Mapping

from ..arguments.require import lookup
from ..devices.outputs.output import with_ramps
from ..safety.limits import Limits
from ..signal import Signal, Stimulus


def render(bank: Mapping[str, Stimulus], name: str, level: float, limits: Limits | None, ramp_s: float = 0.0) -> Signal:
    """The final samples of the stimulus `name` of a bank, with ramps where it does not begin and end at rest.

    Raises
    ------
    InvalidParameter
        If the bank has no such stimulus (with the nearest name), or the stimulus no such level.
    LimitExceeded
        If a limit of the study is passed.
    """
    signal = with_ramps(lookup("stimulus", name, bank).at(level), ramp_s)
    if limits is not None:
        limits.check(signal)
    return signal
