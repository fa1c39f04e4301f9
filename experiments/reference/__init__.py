"""Reference of all file keys, from the classes that read them."""
