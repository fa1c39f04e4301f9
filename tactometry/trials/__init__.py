"""Trials table: rows, columns and cells, for recording and analysis."""
