"""The plate: modes, waves and static bending."""
