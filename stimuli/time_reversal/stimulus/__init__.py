"""As a study names it: set-up, focus and pattern, what is felt, what a vibrometer reads."""
