"""Read-only page that follows a session in a local browser."""
