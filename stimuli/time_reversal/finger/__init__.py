"""What presses on the screen: fingers, contactors, and what they cost."""
