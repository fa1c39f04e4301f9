"""All participants at once: the hierarchical psychometric model."""
