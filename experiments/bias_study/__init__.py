"""Simulation study of estimates: statuses, coverage and bias."""
