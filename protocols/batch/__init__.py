"""Thousands of tracks at once, without a session: a procedure's own transition as machine code."""
