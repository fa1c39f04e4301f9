"""What every waveform is."""

from typing import Protocol, runtime_checkable

from tactometry.signal import Signal

from .level import LevelUnit
from .pieces import Pieces


@runtime_checkable
class Waveform(Protocol):
    """A stimulus with ramps and frequencies, as the ones of this package."""

    @property
    def duration_s(self) -> float: ...

    @property
    def ramp_s(self) -> float: ...

    @property
    def level_unit(self) -> LevelUnit: ...

    @property
    def voltage_frequency_hz(self) -> float: ...

    @property
    def force_frequency_hz(self) -> float: ...

    def at(self, level: float) -> Signal: ...

    def pieces(self, level: float) -> Pieces: ...
