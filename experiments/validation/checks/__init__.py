"""The checks: one question a file, a line each in `CHECKS`."""
