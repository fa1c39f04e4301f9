"""Linear mixed models of values clustered by participant."""
