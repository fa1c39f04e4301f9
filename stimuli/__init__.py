"""Physics and signals between output and skin.

No module here depends on protocols, devices or result files.

`electrovibration`: a voltage attracts a sliding finger. `time_reversal`: waves in a plate focus under a resting finger.
`hybrid`: both on one plate. `perception`: the level of a vibration above the threshold of touch. `scenes`: any
combination of these, computed only as far and as finely as requested. `composition`: the interface of an effect of a
scene.
"""
