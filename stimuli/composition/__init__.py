"""The interface between a scene and its effects."""
