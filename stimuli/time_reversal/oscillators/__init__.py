"""Damped oscillators in time, exact at every sample."""
