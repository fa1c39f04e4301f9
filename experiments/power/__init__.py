"""Power analysis by simulating and testing whole studies."""
