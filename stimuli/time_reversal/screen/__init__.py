"""A plate with transducers and losses."""
