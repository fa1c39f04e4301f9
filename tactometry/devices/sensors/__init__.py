"""Sensors: source interface, reader thread, calibration and drivers."""
