"""PsychoPy plug-in for scripts and Builder experiments."""
