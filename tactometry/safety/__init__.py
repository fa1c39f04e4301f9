"""What may reach a finger: limits, and what an output drives."""
