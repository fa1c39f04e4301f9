"""Safety limits of stimuli, and models of the connected load."""
