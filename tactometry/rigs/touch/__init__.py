"""Touches on the bench: gating of samples, and decisions in sensor threads."""
