"""Electrostatic force: laws, area, polarity, offset, drawn charge."""
