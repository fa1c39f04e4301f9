"""Figures of the thesis, and how they are written."""
