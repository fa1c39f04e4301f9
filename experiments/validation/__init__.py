"""Procedures, fits and tests, validated with simulated participants whose truth is known."""
