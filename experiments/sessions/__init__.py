"""Recorded sessions on any rig, and many simulated sessions."""
