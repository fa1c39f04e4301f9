"""Rules for the next level: immutable and without side effects."""
