"""Clustered values and answers: linear, censored, generalised; Laplace and quadrature."""
