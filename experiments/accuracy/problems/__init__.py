"""Accuracy problems, grouped by topic."""
