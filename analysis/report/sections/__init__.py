"""Presentation of each kind of result on the page, in the terminal and as JSON."""
