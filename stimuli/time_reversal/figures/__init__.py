"""Figures of the thesis."""
