"""Callables of the stages of a time-reversal scene, and the a-priori errors that choose their settings."""
