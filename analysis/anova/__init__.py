"""Within-participant designs: analysis of variance, contrasts, pairs, ranks."""
