"""Callables of stages, and predicted errors shared by effects."""
