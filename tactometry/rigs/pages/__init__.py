"""Pages for the participant as values, and their presentation."""
