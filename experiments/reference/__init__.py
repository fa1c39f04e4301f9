"""Reference of the keys in all files, generated from their classes."""
