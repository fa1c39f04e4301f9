"""Device types by their bench-file names, imported when needed."""

from typing import ClassVar, Final, Protocol

from .outputs.gain import Gain, SignalChain
from .outputs.output import Driver

OUTPUTS: Final = {
    "null": "tactometry.devices.outputs.output:NullSettings",
    "file": "tactometry.devices.outputs.file:FileSettings",
    "packed": "tactometry.devices.outputs.packed:PackedSettings",
    "audio": "tactometry.devices.outputs.audio:AudioSettings",
    "ni": "tactometry.devices.outputs.ni:NiSettings",
}
SENSORS: Final = {
    "lsl": "tactometry.devices.sensors.lsl:LslSettings",
    "serial": "tactometry.devices.sensors.serial_line:SerialSettings",
    "udp": "tactometry.devices.sensors.udp:UdpSettings",
    "audio": "tactometry.devices.sensors.audio:AudioInputSettings",
    "touch": "tactometry.devices.sensors.touch_screen:TouchSettings",
    "recorded": "tactometry.devices.sensors.recorded:RecordedSettings",
}


class OutputSettings(Protocol):
    """Table of an output. `connected` is True if it leads to an amplifier."""

    connected: ClassVar[bool]

    def driver(self, gain: Gain | None) -> Driver:
        """Create the driver. Raises `InvalidParameter` if a gain is missing."""

    def chain(self) -> SignalChain:
        """Return the signal chain for which the gain is valid."""
