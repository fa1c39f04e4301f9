"""PsychoPy plug-in: touches, stimuli, questions and procedures of a study in scripts and Builder experiments."""
