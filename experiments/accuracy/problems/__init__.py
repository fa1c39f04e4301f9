"""Accuracy problems, imported by name."""
