"""A page that follows a session while it runs: what the journal holds, in a browser on the same computer, read-only."""
