"""Kinds of results, a file each: what the page, the terminal and JSON tell of them."""
