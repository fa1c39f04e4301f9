"""What reaches the skin: physics and signals, of which no part knows a protocol, a device or a file of results.

`electrovibration`: a voltage attracts a finger that slides. `time_reversal`: waves in a plate focus under a finger that
rests. `hybrid`: both on one plate. `perception`: how far a vibration is above the threshold of touch. `scenes`: any of
these put together, computed only as far and as finely as asked; `composition` says what an effect of a scene is.
"""
