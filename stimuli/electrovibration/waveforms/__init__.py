"""Voltages as families ordered by level, exactly (pieces) and sampled."""
