"""From samples to a voltage: the seam, the guard before every driver, the drivers."""
