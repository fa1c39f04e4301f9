"""Bench files, calibration, preflight and learned responses."""
