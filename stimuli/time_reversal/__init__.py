"""Time-reversal haptics: plate, focus, driving signals, patterns, finger, sound and energy."""

from tactometry.stimuli.time_reversal.plate import Plate

__all__ = ["Plate"]
