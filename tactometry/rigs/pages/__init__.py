"""The participant's pages as values, and what presents them."""
