"""Voltage waveforms at any level, as exact pieces and as samples."""
