"""Sensors: the source interface, the reader thread, calibration, drivers."""
