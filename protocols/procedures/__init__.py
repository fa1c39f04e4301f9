"""Rules for the next level: frozen, pure."""
