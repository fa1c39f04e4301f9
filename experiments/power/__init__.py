"""Power analysis before data collection, by simulating and testing whole studies."""
