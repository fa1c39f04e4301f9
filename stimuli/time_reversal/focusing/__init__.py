"""From responses to drives: reverse, quantise, repeat."""
