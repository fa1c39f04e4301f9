"""Kinds of results, one file each, for page, terminal and JSON."""
