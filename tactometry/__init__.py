"""Tactometry: psychophysics on touch. The way of a value through the house is in docs/explanation/design.md."""

__version__ = "0.1.0"
