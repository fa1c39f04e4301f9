"""The machinery of ladders: problem, measurement, table, page."""
