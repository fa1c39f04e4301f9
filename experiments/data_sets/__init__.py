"""Recorded data: validated, replayed, exported."""
