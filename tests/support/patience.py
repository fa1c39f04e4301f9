"""How long tests wait for what does not come: a machine that is busy with other things gets all the time it needs."""

LONGEST_WAIT_S = 120.0
"""Longest wait for an event."""
LONGEST_PROGRAM_S = 900.0
"""Longest wait for the end of a program."""
