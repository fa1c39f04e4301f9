"""Models of a participant for simulation: `decisions` defines the interface, `signal_detection` is the default.

They draw from the generator that they get and know no protocol; `finger` simulates touches.
"""
