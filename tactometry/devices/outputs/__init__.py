"""Outputs: the driver interface, the guard and the drivers."""
