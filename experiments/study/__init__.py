"""From a study file to an experiment: tables built, cells wired, sessions planned."""
