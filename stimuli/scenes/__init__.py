"""Scenes: the physics between output and skin, of which only the effects that are called for are computed."""
