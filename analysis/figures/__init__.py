"""Figures of a report; only this package imports matplotlib."""
