"""Touches on the bench: gated samples, and decisions in sensor threads."""
