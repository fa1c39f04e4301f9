"""A finger that slides or sticks under that force: exact propagators, event-exact friction."""
