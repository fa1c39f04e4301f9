"""Scenes: the physics between output and skin, computed on demand."""
