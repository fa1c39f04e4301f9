"""Figures of the thesis, and their files."""
