"""Impulse responses: of the model, loaded, filtered, learnt, measured; what is read off them."""
