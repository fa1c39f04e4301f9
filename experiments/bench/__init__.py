"""A bench: its file, calibration, preflight, learnt responses."""
