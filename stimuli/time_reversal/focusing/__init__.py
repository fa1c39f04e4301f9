"""Drives from responses: reversal, quantisation and repetition."""
