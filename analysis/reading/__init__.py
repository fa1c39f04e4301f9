"""From files to a checked table of trials: what is used, left out, and of what quality."""
