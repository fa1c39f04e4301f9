"""Read-only page in a local browser that follows a session."""
