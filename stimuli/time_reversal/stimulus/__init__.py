"""Time-reversal stimuli of studies: setup, patterns and sensation."""
