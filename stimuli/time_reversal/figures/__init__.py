"""The thesis's figures as functions, each of which returns a matplotlib figure; `gallery` draws all of them."""
