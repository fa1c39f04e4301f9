"""What of the thesis comes out of the house; `items` has a file for what one computation or chapter gives."""
