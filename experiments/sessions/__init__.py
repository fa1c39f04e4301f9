"""A session from start to end on any rig, and many simulated ones."""
