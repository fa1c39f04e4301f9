"""A psychometric function fitted to counts."""
