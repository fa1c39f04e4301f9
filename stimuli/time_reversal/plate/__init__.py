"""The plate: material, size, edges; its modes, waves and static bending."""
