"""The electrical model of a finger on a screen, solved exactly."""
