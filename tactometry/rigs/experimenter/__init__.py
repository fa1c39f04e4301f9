"""The experimenter's side: orders, pauses, the log of trials."""
