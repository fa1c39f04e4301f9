"""Modes of a rectangle by its sides, edges and Poisson ratio: no material, no frequency."""
