"""Strict reading of TOML files that users write, with units."""
