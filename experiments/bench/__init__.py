"""Bench files, calibration, preflight checks and learned responses."""
