"""The volume of a sound server, which stands between a sample and the connector."""

import contextlib
import json
import subprocess
from typing import Any, Final

SERVERS: Final = ("pulse", "pipewire")
"""Devices of PortAudio on Linux that lead to a sound server, by the server's default sink."""
ASKED_WITHIN_S: Final = 2.0


def system_volume(device: str) -> float | None:
    """The volume of the sink that a device leads to, 1 for 100 % and 0 where it is muted.

    None where no sound server is between, or where its volume cannot be read: a card's own mixer, macOS and Windows
    are not read. Of several channels the loudest counts.
    """
    if device not in SERVERS:
        return None
    with contextlib.suppress(OSError, subprocess.SubprocessError, ValueError, KeyError, IndexError):
        default = _pactl("info")["default_sink_name"]
        # none or several of the name: a ValueError, and the volume is not known
        [sink] = [sink for sink in _pactl("list", "sinks") if sink["name"] == default]
        return _volume_of(sink)
    return None


def _volume_of(sink: Any) -> float:
    """The volume of a sink as ``pactl`` describes it.

    >>> _volume_of({"mute": False, "volume": {"left": {"value": 65536}, "right": {"value": 32768}}})
    1.0
    >>> _volume_of({"mute": True, "volume": {"mono": {"value": 65536}}})
    0.0
    """
    loudest = max(channel["value"] for channel in sink["volume"].values())
    return 0.0 if sink["mute"] else float(loudest) / 65_536


def _pactl(*arguments: str) -> Any:
    command = ["pactl", "--format=json", *arguments]
    answer = subprocess.run(command, capture_output=True, text=True, timeout=ASKED_WITHIN_S, check=True)
    return json.loads(answer.stdout)
