"""Data classes for the tables of a bench file."""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated

from annotated_types import Ge, Interval

from tactometry.arguments.constraints import Finite, Share, constrained
from tactometry.arguments.require import expect, not_zero, one_of, some
from tactometry.devices.kinds import OutputSettings
from tactometry.devices.outputs.gain import Gain, required_gain
from tactometry.devices.outputs.output import RAMP_S, NullSettings
from tactometry.devices.sensors.reader import Reader, SensorSettings
from tactometry.devices.sensors.streamed import ForceCalibration
from tactometry.rigs.texts import languages
from tactometry.safety.load import Load
from tactometry.session.event import TRACE_KINDS, TraceKind

if TYPE_CHECKING:
    from tactometry.rigs.window import Window

LONGEST_DELAY_S = 0.05
"""Half of the time after which a silent sensor counts as lost. The delay adds to the time until a stop (unverified
default)."""


@dataclass(frozen=True)
@constrained
class DisplayTable:
    """The participant's screen: full screen or a window.

    - `fullscreen`: Use the whole screen instead of a window.
    - `width_px`: Width of the window.
    - `height_px`: Height of the window.
    - `height_m`: Height of the screen, measured with `tactometry calibrate display`.
    - `language`: Language of the participant's pages.
    - `dry_run`: Show each kind of touch and let the participant try it without a stimulus, before the first trial.
    - `screen`: Number of the screen, counted from 0.
    """

    fullscreen: bool = True
    width_px: Annotated[int, Ge(320)] = 1280
    height_px: Annotated[int, Ge(320)] = 800
    height_m: Annotated[float, Interval(gt=0, lt=10)] | None = None
    language: str = "en"
    dry_run: bool = True
    screen: Annotated[int, Ge(0)] = 0

    def __post_init__(self) -> None:
        one_of("DisplayTable.language", self.language, languages())

    def window(self) -> "Window":
        """Open the participant's window.

        Raises `InvalidParameter` if the screen is not connected. Raises `DeviceFailed` if the window does not open.
        """
        from tactometry.rigs.window import Window

        return Window(fullscreen=self.fullscreen, size=(self.width_px, self.height_px), screen=self.screen)


@dataclass(frozen=True)
@constrained
class OutputPart:
    """The output device, its gain and load, and the ramps of its signals.

    - `settings`: Settings of the device.
    - `gain`: Voltage at the load for a sample value of 1. Required if an amplifier is connected.
    - `load`: Electrical load of the output.
    - `ramp_s`: Duration of the ramps at both ends of each signal. 0 for a one-bit `packed` output.
    - `ungated`: Allow the output to play under a finger without a force sensor.
    """

    settings: OutputSettings = field(default_factory=NullSettings)
    gain: Gain | None = None
    load: Load | None = None
    ramp_s: Share = RAMP_S
    ungated: bool = False

    def __post_init__(self) -> None:
        if self.settings.connected:
            required_gain(self.gain, "OutputPart.gain")


@dataclass(frozen=True)
@constrained
class SensorPart:
    """A sensor and the delay of its time stamps.

    - `settings`: Settings of the device.
    - `delay_s`: Measured delay of the time stamps after the event.
    """

    settings: SensorSettings
    delay_s: Annotated[float, Interval(ge=0, le=LONGEST_DELAY_S)] = 0.0

    def reader(self) -> Reader:
        return Reader(self.settings.source(), self.delay_s)


@dataclass(frozen=True)
class ForcePart:
    """The force: one channel of a sensor, with its calibration.

    - `sensor`: Name of a sensor in `[sensors]`.
    - `calibration`: Conversion of counts to newtons.
    - `channel`: Channel of the sensor, from 0.
    - `release`: True if the force must leave its band between touches.
    """

    sensor: str
    calibration: ForceCalibration
    channel: int = 0
    release: bool = True


@dataclass(frozen=True)
@constrained
class PositionPart:
    """The finger's position: one channel of a sensor for each axis.

    - `sensor`: Name of a sensor in `[sensors]`.
    - `channels`: Channels of the sensor, from 0, one for each axis. A slide's path lies along the first axis.
    - `metres_per_count`: Scale of the counts. Negative if the counts decrease along the path.
    - `zero_counts`: Counts of each channel at position 0, which is the start of a slide's path.
    - `count_low`: Lowest count that is a position. Samples with lower counts are missing.
    - `count_high`: Highest count that is a position, such as 254 if 255 means overload. Samples with higher counts are
      missing.
    """

    sensor: str
    channels: tuple[int, ...]
    metres_per_count: float
    zero_counts: tuple[Finite, ...] = ()
    count_low: float = -math.inf
    count_high: float = math.inf

    def __post_init__(self) -> None:
        some("PositionPart.channels", self.channels)
        n_zeros = len(self.zero_counts)
        expect(n_zeros in (0, len(self.channels)), "PositionPart.zero_counts", n_zeros, "one for each channel, or none")
        not_zero("PositionPart", metres_per_count=self.metres_per_count)
        rises = self.count_low < self.count_high
        expect(rises, "PositionPart.count_low", self.count_low, f"below count_high, {self.count_high}")


@dataclass(frozen=True)
class Learnt:
    """Measured impulse responses of this bench.

    - `responses`: File written by `tactometry calibrate responses`.
    """

    responses: str


@dataclass(frozen=True)
class TracesTable:
    """Kinds of samples that are stored for each touch.

    - `force`: Store samples of the force sensor.
    - `position`: Store samples of the position sensor.
    - `emitted`: Store the emitted signal if it followed the finger.
    """

    force: bool = True
    position: bool = True
    emitted: bool = True

    @property
    def kept(self) -> tuple[TraceKind, ...]:
        return tuple(kind for kind in TRACE_KINDS if getattr(self, kind))
