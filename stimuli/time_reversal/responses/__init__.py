"""Impulse responses: modelled, loaded, learnt and measured."""
