"""Bayesian procedures on a grid of parameters: QUEST, QUEST+, psi."""
