"""Presentation of each kind of result."""
