"""Reading, checking and selection of trials, and the quality of the data."""
