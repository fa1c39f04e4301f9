"""What an argument must be, and the sentence that refuses it."""
