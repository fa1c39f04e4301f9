"""Record sessions on any rig, and simulate many sessions."""
