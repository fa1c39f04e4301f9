"""Textures: friction as a function of the finger's position."""
