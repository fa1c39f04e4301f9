"""Pages of the participant as values, and their presentation."""
