"""What changes in a simulated participant during a session: one file each, none imported unless a study names it."""
