"""Validation, replay and export of recorded data sets."""
