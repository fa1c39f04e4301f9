"""Shared parts of sound-card drivers: import of PortAudio, and closing."""

import atexit
from types import ModuleType
from typing import Any, Final

from ..arguments.require import expect
from ..errors import DeviceFailed, library_needed
from .clock_map import CLOSE_WITHIN_S, within

FULL_SCALE = {"int16": 2**15 - 1, "int32": 2**31 - 1, "float32": 1}
"""Number that represents 1 in each sample format."""
DEFAULTS: Final = ("default", "sysdefault")
"""Names of devices that depend on the system's settings."""


def end_stream(stream: Any, name: str) -> None:
    """Close a stream, even if it hangs with its sound server."""

    def end() -> None:
        stream.abort()
        stream.close()

    try:
        within(CLOSE_WITHIN_S, name, end)
    except DeviceFailed:
        # its exit handler would wait for the same server forever
        atexit.unregister(library()._exit_handler)
        raise


def refuse_default(owner: str, device: str) -> None:
    """Refuse a device name that changes with the system's settings."""
    named = device.strip().casefold() not in ("", *DEFAULTS)
    card = "the name of a card (listed by python -m sounddevice), because a default may change"
    expect(named, f"{owner}.device", repr(device), card)


def library() -> ModuleType:
    """Import PortAudio. Raises `DeviceFailed`."""
    with library_needed(
        "audio: cannot load PortAudio ({error}); pip install 'tactometry[audio]', and on Debian apt-get install "
        "libportaudio2; nothing was played"
    ):
        import sounddevice
    module: ModuleType = sounddevice
    return module
