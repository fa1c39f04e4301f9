"""Semantic differentials: scores, consistency, patterns of the thesis."""
