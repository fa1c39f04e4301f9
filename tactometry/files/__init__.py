"""Reading of files within limits, and complete, private writing."""
