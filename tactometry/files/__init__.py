"""Files as data need them: read for what they are and no more, written whole, and open to nobody else."""
