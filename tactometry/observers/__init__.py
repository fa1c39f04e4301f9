"""Models of a participant for simulation.

`decisions` defines the interface, `signal_detection` is the default. They draw from the generator passed to them and
are independent of protocols; `finger` simulates touches.
"""
