"""Shipped forms of choice questions, one TOML file each."""
