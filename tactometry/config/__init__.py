"""Files that people write: TOML, strictly read, quantities with units."""
