"""Figures of the thesis; `gallery` draws all of them."""
