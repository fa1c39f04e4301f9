"""Guests in PsychoPy: parts of a study within a script or a Builder experiment that stays in charge."""
