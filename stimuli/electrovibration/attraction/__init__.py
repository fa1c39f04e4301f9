"""Electrostatic force: laws, contact area, polarity and offset."""
