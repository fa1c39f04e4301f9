"""Physics and signals between output and skin.

No module here depends on protocols, devices or result files.

`electrovibration`: a voltage attracts a finger that slides. `time_reversal`: waves in a plate focus under a finger that
rests. `hybrid`: both on one plate. `perception`: how far a vibration is above the threshold of touch. `scenes`: any of
these put together, computed only as far and as finely as asked; `composition` says what an effect of a scene is.
"""
