"""What an effect of a scene is, below the physics: a value says itself what it needs, gives and asks of the others."""
