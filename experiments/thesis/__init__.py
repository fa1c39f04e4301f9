"""What of the thesis comes out of the house; `items` has a file for each table and finding."""
