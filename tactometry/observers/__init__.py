"""Models of a participant for simulation.

`decisions` defines their interface. `signal_detection` is the default. Models draw from the generator passed to them
and do not depend on protocols. `finger` simulates touches.
"""
