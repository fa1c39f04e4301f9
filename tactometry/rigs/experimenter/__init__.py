"""Terminal of the experimenter: commands, pauses and the log of trials."""
