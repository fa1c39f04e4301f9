"""Motion of a sliding or sticking finger, with exact events."""
