"""Study files, and their wiring into cells, sessions and experiments."""
