"""What becomes of the estimates of simulated participants: statuses, coverage, bias."""
