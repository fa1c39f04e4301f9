"""Reference of the keys in all files, generated from the classes that read them."""
