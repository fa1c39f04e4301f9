"""Models of a participant, for simulation: `decisions` says what one promises, `signal_detection` is the shipped one.

They draw from the generator that they are given and know no protocol; `finger` is how a simulated finger presses and
slides, and `tactometry.rigs.simulated` asks both.
"""
