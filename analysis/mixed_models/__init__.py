"""Mixed models of clustered values and answers."""
