"""Power of a study before it is run: whole studies are simulated and tested."""
