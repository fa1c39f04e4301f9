"""Simulation of thousands of tracks at once in machine code."""
