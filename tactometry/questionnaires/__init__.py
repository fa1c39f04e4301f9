"""Shipped questionnaires, one TOML file each."""
