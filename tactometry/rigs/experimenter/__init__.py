"""Experimenter's terminal: commands, pauses and the log of trials."""
