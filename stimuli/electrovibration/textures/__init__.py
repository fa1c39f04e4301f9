"""How strong the friction is to be where the finger is."""
