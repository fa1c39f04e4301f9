"""Decisions on sample stamps: is the force held, is the finger in motion."""
